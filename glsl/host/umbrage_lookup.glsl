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
uint umbrage_layer_count(uvec2 layers) { return layers.y == 0u ? 1u : 2u; }
uint umbrage_layer(uvec2 layers, uint i) { return i == 0u ? layers.x : layers.y - 1u; }

// Depths of the nearest casters at the texels low, low + (1, 0), low + (0, 1) and low + (1, 1).
vec4 caster_quad(uvec2 layers, vec2 low) {
    // the gather of a nearest sampler: its four texels meet at the coordinate given
    vec2 meet = (low + 1.0) / vec2(textureSize(atlas, 0).xy);
    vec4 casters = vec4(0.0);
    uint count = umbrage_layer_count(layers);
    for (uint i = 0u; i < count; i++) {
        casters = max(casters, textureGather(atlas, vec3(meet, float(umbrage_layer(layers, i))), 0).wzxy);
    }
    return casters;
}

// 1 lit, 0 shadowed. Each test of a texel is against the receiver's plane at its centre, so that a plane never shadows itself
// (book, 5.1.4). Where the four nearest tests differ, the edge is the line midway between the lit and the dark of the 4 x 4
// nearest texels, across the direction in which light increases; where no such line parts them, the contour at which the
// bilinear blend of the nearest four is one half.
float umbrage_plane_visibility(Plane plane, uvec2 layers) {
    vec2 low = floor(plane.texel - 0.5);
    vec2 f = plane.texel - 0.5 - low;
    float first = plane.depth - dot(plane.slope, f);
    vec4 depths = vec4(first, first + plane.slope.x, first + plane.slope.y, first + plane.slope.x + plane.slope.y);
    vec4 lit = vec4(greaterThanEqual(depths, caster_quad(layers, low)));
    // loops that turn no time, not branches: some devices run both sides of those
    uint quads = any(notEqual(lit, lit.xxxx)) ? 4u : 0u;
    vec2 rise = vec2(0.0);
    uint tests = 0u;
    for (uint q = 0u; q < quads; q++) {
        vec2 side = 2.0 * vec2(q & 1u, q >> 1) - 1.0;
        vec4 here = vec4(greaterThanEqual(depths + dot(plane.slope, side), caster_quad(layers, low + side)));
        rise += 2.0 * side * dot(here, vec4(1.0)) + vec2(here.y + here.w - here.x - here.z, here.z + here.w - here.x - here.y);
        tests |= uint(dot(here, vec4(1.0, 2.0, 4.0, 8.0))) << (4u * q);
    }
    // places along `rise` from the middle of the 16, in halves of a texel
    float least_lit = 1e30;
    float most_dark = -1e30;
    for (uint q = 0u; q < quads; q++) {
        vec4 along = vec4(-rise.x - rise.y, rise.x - rise.y, rise.y - rise.x, rise.x + rise.y) + 2.0 * dot(rise, 2.0 * vec2(q & 1u, q >> 1) - 1.0);
        bvec4 here = notEqual(uvec4(tests >> (4u * q)) & uvec4(1u, 2u, 4u, 8u), uvec4(0u));
        vec4 high = mix(vec4(1e30), along, here);
        vec4 deep = mix(along, vec4(-1e30), here);
        least_lit = min(least_lit, min(min(high.x, high.y), min(high.z, high.w)));
        most_dark = max(most_dark, max(max(deep.x, deep.y), max(deep.z, deep.w)));
    }
    bool parted = quads > 0u && most_dark < least_lit;
    bool above = 2.0 * dot(rise, 2.0 * f - 1.0) > most_dark + least_lit;
    bool blend = dot(lit, vec4((1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y)) >= 0.5;
    return (parted ? above : blend) ? 1.0 : 0.0;
}

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
    return umbrage_plane_visibility(umbrage_plane(light, r, entry), umbrage_layers(entry));
}
