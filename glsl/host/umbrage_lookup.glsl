// Visibility of a point towards a light through the page table and the atlas.
// Needs key.glsl, light_receiver.glsl, table.glsl, `frame`, `table_keys`, `entries`, `atlas` (sampler2DArray) and the
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

// A receiver in the page that serves it.
struct PageSample {
    uint entry;
    vec2 texel;         // place in the page, gutter included
    vec2 slope;         // change of stored depth per texel along the receiver's plane
    float depth;        // stored depth of the receiver
    float bias;         // nearer to the light by this, it is compared
    float texel_depth;  // stored depth of a texel's world size
};

// Whether a page serves the receiver.
bool umbrage_sample(uint slot, Light light, Receiver r, out PageSample s) {
    s.entry = umbrage_entry(key_of(r.level, slot * FACES + r.face, uvec2(r.page) >> r.level));
    if (s.entry == 0u) {
        return false;
    }
    int level = entry_level(s.entry);
    vec2 in_page = (vec2(r.page - ((r.page >> level) << level)) + r.inside) * power_of_two(-level);
    s.texel = in_page * frame.rule.x + float(GUTTER);
    float units = power_of_two(level) / frame.rule.x;
    s.texel_depth = r.per_length * r.unit * units;
    s.slope = clamp(r.slope * units, -200.0 * s.texel_depth, 200.0 * s.texel_depth);
    s.depth = r.depth;
    s.bias = frame.rule.y * receiver_bias(s.texel_depth, s.slope) + light.rule.y * r.per_length;
    if (entry_turned(s.entry)) {
        // texels and depths may be off by this many texels, and depths by as much of the slope
        s.bias += frame.rule.z * (s.texel_depth + abs(s.slope.x) + abs(s.slope.y));
    }
    return true;
}

// Depths of the four texels that meet at a texel corner, in the order of rows. The gather of a nearest sampler: its four
// texels meet at the coordinate given.
vec4 umbrage_casters(uint entry, vec2 corner) {
    vec2 meet = corner / vec2(textureSize(atlas, 0).xy);
    vec4 casters = textureGather(atlas, vec3(meet, float(entry_slot(entry))), 0).wzxy;
    uint moving = entry_dynamic(entry);
    return moving != 0u ? max(casters, textureGather(atlas, vec3(meet, float(moving - 1u)), 0).wzxy) : casters;
}

// The contour where the bilinear blend of the four nearest tests is one half: a smoother and closer edge than the
// nearest texel's. Each test is against the receiver's plane at that texel's centre, so that a plane never shadows
// itself (book, 5.1.4).
float umbrage_contour(PageSample s) {
    vec2 low = floor(s.texel - 0.5);
    vec2 f = s.texel - 0.5 - low;
    float first = s.depth + s.bias - dot(s.slope, f);
    vec4 plane = vec4(first, first + s.slope.x, first + s.slope.y, first + s.slope.x + s.slope.y);
    vec4 lit = vec4(greaterThanEqual(plane, umbrage_casters(s.entry, low + 1.0)));
    return dot(lit, vec4((1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y)) >= 0.5 ? 1.0 : 0.0;
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
    PageSample s;
    return umbrage_sample(slot, light, r, s) ? umbrage_contour(s) : 0.0;
}
