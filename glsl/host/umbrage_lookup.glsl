// Visibility of a point towards a light through the page table and the atlas.
// Needs key.glsl, receiver.glsl, light_receiver.glsl, table.glsl, `frame`, `table_keys`, `entries`, `atlas` (sampler2DArray) and the
// constants TABLE_SIZE and GUTTER.

#include "shared/entry.glsl"

// The entry that serves a page: its own, or that of the nearest ancestor in the table; 0 if none.
// One loop over probes and levels: nearly every pixel leaves it at the first probe.
uint umbrage_entry(uvec2 key) {
    uint slot = table_slot(key);
    uint probes = 0u;
    while (true) {
        uvec2 stored = table_key(slot);
        uint entry = stored == key ? entries[slot] : 0u;
        if (entry != 0u) {
            return entry;
        }
        // the key is not there, or the table overflowed and left it without an entry: ask the parent
        if (stored.x == 0u || stored == key || ++probes == MAX_PROBES) {
            if (key_level(key) == ROOT_LEVEL) {
                break;
            }
            key = key_ancestor(key, 1);
            slot = table_slot(key);
            probes = 0u;
        } else {
            slot = (slot + 1u) & (TABLE_SIZE - 1u);
        }
    }
    return 0u;
}

// The receiver's plane in the layers of the page that serves it. `light`: its record.
Plane umbrage_plane(Light light, Receiver r, uint entry) {
    int level = entry_level(entry);
    vec2 in_page = (vec2(r.page - ((r.page >> level) << level)) + r.inside) * power_of_two(-level);
    float units = power_of_two(level) / frame.rule.x;
    float texel_depth = r.per_length * r.unit * units;
    vec2 slope = clamp(r.slope * units, -200.0 * texel_depth, 200.0 * texel_depth);
    float bias = frame.rule.y * receiver_bias(texel_depth, slope) + light.rule.y * r.per_length;
    if (entry_turned(entry)) {
        // texels and depths may be off by this many texels, and depths by as much of the slope
        bias += frame.rule.z * (texel_depth + abs(slope.x) + abs(slope.y));
    }
    return Plane(in_page * frame.rule.x + float(GUTTER), r.depth + bias, slope, bias);
}

// The layers of the page that serves: of its casters that stand still, and of those that move + 1, 0 without.
uvec2 umbrage_layers(uint entry) { return uvec2(entry_slot(entry), entry_dynamic(entry)); }

// A loop over these instead of a branch: where devices run both sides of a branch, pages without moving casters read one layer.
// A `for` loop: with `do` around a gather, Mesa 22.3's lavapipe gave wrong depths where neighbours differ in their layers.
uint layer_count(uvec2 layers) { return layers.y == 0u ? 1u : 2u; }
uint layer_of(uvec2 layers, uint i) { return i == 0u ? layers.x : layers.y - 1u; }

// Depths in a layer at the texels low, low + (1, 0), low + (0, 1) and low + (1, 1).
vec4 layer_quad(uint layer, vec2 low) {
    // the gather of a nearest sampler: its four texels meet at the coordinate given
    return textureGather(atlas, vec3((low + 1.0) / vec2(textureSize(atlas, 0).xy), float(layer)), 0).wzxy;
}

// Of the nearest casters in all layers.
vec4 caster_quad(uvec2 layers, vec2 low) {
    vec4 casters = vec4(0.0);
    uint count = layer_count(layers);
    for (uint i = 0u; i < count; i++) {
        casters = max(casters, layer_quad(layer_of(layers, i), low));
    }
    return casters;
}

#include "shared/contour.glsl"

// 1 lit, 0 shadowed or not reached by the light. `slot`: of the light, whose record is `light`; `from_eye`: position
// relative to the eye; `n`: geometric normal towards the eye; `dx`, `dy`: derivatives of the position per pixel on the
// receiver's plane. World space.
// A light that no page serves, because the atlas is full or its first page is yet to be drawn, is dark.
float umbrage_visibility(uint slot, Light light, vec3 from_eye, vec3 n, vec3 dx, vec3 dy) {
    Receiver r;
    if (!light_receiver(frame, light, from_eye, n, dx, dy, r)) {
        return 0.0;
    }
    // beyond all casters
    if (!on_face(r.page)) {
        return 1.0;
    }
    uint entry = umbrage_entry(key_of(r.level, slot * FACES + r.face, uvec2(r.page) >> r.level));
    if (entry == 0u) {
        return 0.0;
    }
    return contour_visibility(umbrage_plane(light, r, entry), umbrage_layers(entry));
}
