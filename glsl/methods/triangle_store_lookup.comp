#version 460
#extension GL_GOOGLE_include_directive : require
#define STORED
#include "methods/map_lookup.glsl"

// The light's ray to a sample against the triangles that the texels around it hold (Dai et al. 2008; book, 2.2.4 and 4.6.3).
#include "shared/structs.glsl"
#include "shared/split.glsl"
#define RAY_BINDING 11
#define RAY_CONSTANT 11
#include "shared/ray_hit.glsl"
#include "methods/compared.glsl"
#include "methods/corner.glsl"
layout(constant_id = 14) const int SEARCHED = 1;       // texels around a sample's own, either way
layout(constant_id = 15) const uint UNCOVERED = 0u;    // what decides where no stored triangle lies over a sample: as `Uncovered`
layout(constant_id = 16) const bool OWN = false;       // whether `owners` are there
layout(constant_id = 17) const bool ALPHA = false;     // whether any caster is alpha tested
layout(std430, binding = 17) readonly buffer Indices { uint indices[]; };

const uint UNCOVERED_LIT = 0u;
const uint UNCOVERED_DEPTH = 1u;
const uint UNCOVERED_SMALL = 2u;
const uint UNCOVERED_AGREE = 3u;
const uint UNCOVERED_BOTH = 4u;

uvec3 vertices_of(vec2 stored) {
    uint first = 3u * (uint(stored.y) - 1u);
    return uvec3(indices[first], indices[first + 1u], indices[first + 2u]);
}

// Whether a stored triangle lies between a sample and the light.
bool shadows(vec2 stored, uint face, vec3 from, uvec2 own) {
    if (stored.y == 0.0 || OWN && uvec2(stored) == own) {
        return false;
    }
    uint index = uint(stored.x);
    Instance instance = instances[index];
    Met met = Met(uint(stored.y) - 1u, vertices_of(stored), vec3(0.0));
    uvec3 v = met.vertices;
    vec3 a = corner_at(face, instance, v.x), b = corner_at(face, instance, v.y), c = corner_at(face, instance, v.z);
    bool hit = met_at(from, a, b, c, met.weights);
    if (ALPHA && hit && (instance.flags & ALPHA_TESTED) != 0u) {
        hit = solid(index, met);
    }
    return hit;
}

// Whether the triangle of a texel is smaller than a texel, so that others may lie between it and the next.
bool small(vec2 stored, uint face, Place p) {
    if (stored.y == 0.0) {
        return false;
    }
    Instance instance = instances[uint(stored.x)];
    uvec3 v = vertices_of(stored);
    vec3 a = corner_at(face, instance, v.x), b = corner_at(face, instance, v.y), c = corner_at(face, instance, v.z);
    vec2 ta = a.xy / divisor(a.z), tb = b.xy / divisor(b.z), tc = c.xy / divisor(c.z);
    float twice = abs((tb.x - ta.x) * (tc.y - ta.y) - (tb.y - ta.y) * (tc.x - ta.x));
    float limit = UNCOVERED == UNCOVERED_SMALL ? 1.0 : UNCOVERED == UNCOVERED_AGREE ? 4.0 : 16.0;
    return 0.5 * twice * divisor(p.ls.z) * divisor(p.ls.z) < limit * p.size.x * p.size.y;
}

bool lit_by_stored(uint layer, uvec2 pixel, Sample s, Place p, Held held) {
    ivec2 middle = ivec2(p.texel);
    ivec2 last = textureSize(map, 0).xy - 1;
    uint face = face_of(layer);
    vec3 from = compared(face, ray_start(s.from_eye, s));
    uvec2 own = OWN ? texelFetch(owners, ivec2(pixel), 0).xy : uvec2(0u);
    int side = 2 * SEARCHED + 1;
    vec2 before = vec2(0.0);
    for (int i = 0; i < side * side; i++) {
        ivec2 texel = clamp(middle + ivec2(i % side, i / side) - SEARCHED, ivec2(0), last);
        vec2 stored = texelFetch(second_map, ivec3(texel, layer), 0).rg;
        // neighbours often hold the same triangle
        if (stored != before && shadows(stored, face, from, own)) {
            return false;
        }
        before = stored;
    }
    bool trusted = UNCOVERED != UNCOVERED_LIT;
    if (UNCOVERED >= UNCOVERED_SMALL) {
        trusted = small(texelFetch(second_map, ivec3(middle, layer), 0).rg, face, p);
    }
    return !trusted || lit_by(layer, held, middle);
}
