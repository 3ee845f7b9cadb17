// Filtered visibility of a point towards a light. Needs umbrage_lookup.glsl and what that needs, `ranges` (least and greatest
// stored depth of each layer of the atlas) and the constants FILTER, not FILTER_HARD, TAPS, RANGED and LEVEL_BLEND.

float layer_depth(uint layer, vec2 texel) { return texelFetch(atlas, ivec3(texel, layer), 0).r; }

#include "shared/kernel.glsl"

float umbrage_page_visibility(Light light, Receiver r, uint entry, uvec2 pixel) {
    Plane plane = umbrage_plane(light, r, entry);
    uvec2 layers = umbrage_layers(entry);
    if (RANGED) {
        vec2 range = ranges[layers.x];
        if (layers.y != 0u) {
            range = max(range, ranges[layers.y - 1u]);
        }
        // wholly before or behind all casters of the page
        float reach = kernel_reach(plane);
        if (plane.depth - reach >= range.y) {
            return 1.0;
        }
        if (plane.depth + reach < range.x) {
            return 0.0;
        }
    }
    return kernel_visibility(plane, layers, pixel);
}

// As umbrage_visibility, but from 0 to 1. `pixel`: of the image, for the rotation of the Poisson disc.
float umbrage_filtered(uint slot, Light light, vec3 from_eye, vec3 n, vec3 dx, vec3 dy, uvec2 pixel) {
    Receiver r;
    if (!light_receiver(frame, light, from_eye, n, dx, dy, r)) {
        return 0.0;
    }
    if (!on_face(r.page)) {
        return 1.0;
    }
    uint face = slot * FACES + r.face;
    uint entry = umbrage_entry(key_of(r.level, face, uvec2(r.page) >> r.level));
    if (entry == 0u) {
        return 0.0;
    }
    float lit = umbrage_page_visibility(light, r, entry, pixel);
    if (LEVEL_BLEND && r.coarser > 0.0) {
        uint coarse = umbrage_entry(key_of(r.level + 1, face, uvec2(r.page) >> (r.level + 1)));
        if (coarse != entry && coarse != 0u) {
            lit = mix(lit, umbrage_page_visibility(light, r, coarse, pixel), r.coarser);
        }
    }
    return lit;
}
