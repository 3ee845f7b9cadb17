// Visibility of a point towards the light through the page table and the atlas.
// Needs `frame`, `table_keys`, `entries`, `atlas` (sampler2DArray) and the constants TABLE_SIZE and GUTTER.

#include "shared/entry.glsl"

// The entry that serves a level-0 page at a level: its own, or that of the nearest ancestor in the table; 0 if none.
// One loop over probes and levels: nearly every pixel leaves it at the first probe.
uint umbrage_entry(ivec2 page, int level) {
    uint key = key_of(level, uvec2(page) >> level);
    uint slot = table_slot(key);
    uint probes = 0u;
    while (true) {
        uint stored = table_keys[slot];
        uint entry = stored == key ? entries[slot] : 0u;
        if (entry != 0u) {
            return entry;
        }
        // the key is not there, or the table overflowed and left it without an entry: ask the parent
        if (stored == 0u || stored == key || ++probes == MAX_PROBES) {
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

// 1 lit, 0 shadowed. `from_eye`: position relative to the eye; `n`: geometric normal towards the eye;
// `dx`, `dy`: derivatives of the position per pixel on the receiver's plane. World space.
float umbrage_visibility(vec3 from_eye, vec3 n, vec3 dx, vec3 dy) {
    vec3 normal = vec3(dot(frame.light_x.xyz, n), dot(frame.light_y.xyz, n), dot(frame.light_z.xyz, n));
    if (normal.z >= 0.0) {
        return 0.0;
    }
    ivec2 page;
    vec2 inside;
    light_page(frame, from_eye, page, inside);
    if (!on_grid(page)) {
        return 1.0;
    }
    vec2 ls_dx, ls_dy;
    light_derivatives(frame, dx, dy, ls_dx, ls_dy);
    uint entry = umbrage_entry(page, footprint_level(frame, ls_dx, ls_dy));
    if (entry == 0u) {
        return 1.0;
    }
    int level = entry_level(entry);
    vec2 in_page = (vec2(page - ((page >> level) << level)) + inside) * power_of_two(-level);
    vec2 texel = in_page * frame.rule.w + float(GUTTER);
    float texel_size = frame.page.x * power_of_two(level) / frame.rule.w;
    // The contour where the bilinear blend of the four nearest tests is one half: a smoother and closer edge than the
    // nearest texel's. Each test is against the receiver's plane at that texel's centre, so that a plane never shadows
    // itself (book, 5.1.4).
    vec2 slope = clamp(-normal.xy / normal.z, -200.0, 200.0) * texel_size;
    float bias = frame.rule.y * receiver_bias(texel_size, slope) + frame.rule.z;
    if (entry_turned(entry)) {
        // texels and depths may be off by this many texels, and depths by as much of the slope
        bias += frame.drift.y * (texel_size + abs(slope.x) + abs(slope.y));
    }
    float depth = frame.light_z.w + dot(frame.light_z.xyz, from_eye) - bias;
    vec2 low = floor(texel - 0.5);
    vec2 f = texel - 0.5 - low;
    float first = depth - dot(slope, f);
    vec4 plane = vec4(first, first + slope.x, first + slope.y, first + slope.x + slope.y) * frame.page.z;
    // the gather of a nearest sampler: its four texels meet at the coordinate given
    vec2 meet = (low + 1.0) / vec2(textureSize(atlas, 0).xy);
    vec4 casters = textureGather(atlas, vec3(meet, float(entry_slot(entry))), 0).wzxy;
    uint moving = entry_dynamic(entry);
    if (moving != 0u) {
        casters = min(casters, textureGather(atlas, vec3(meet, float(moving - 1u)), 0).wzxy);
    }
    vec4 lit = vec4(lessThanEqual(plane, casters));
    return dot(lit, vec4((1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y)) >= 0.5 ? 1.0 : 0.0;
}
