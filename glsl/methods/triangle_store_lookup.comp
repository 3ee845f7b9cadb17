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

layout(std430, binding = 18) readonly buffer Adjacency { uint behind[]; };  // with UNCOVERED_WALK; see src/methods/triangle_store.rs

const uint UNCOVERED_WALK = 0u;
const uint UNCOVERED_DEPTH = 1u;
const uint UNCOVERED_LIT = 2u;

// Triangles of a walk: a texel's own, and as many behind it.
const int STEPS = 12;

// What a triangle says of the light's ray to a sample: whether the ray meets it before the sample, and the weights of its corners
// where the ray meets its plane.
bool shadows(uint index, uint triangle, uint face, vec3 from, uvec2 own, out vec3 weights) {
    Instance instance = instances[index];
    uint first = 3u * triangle;
    uvec3 v = uvec3(indices[first], indices[first + 1u], indices[first + 2u]);
    vec3 a = corner_at(face, instance, v.x), b = corner_at(face, instance, v.y), c = corner_at(face, instance, v.z);
    bool met = met_at(from, a, b, c, weights) && !(OWN && uvec2(index, triangle + 1u) == own);
    if (ALPHA && met && (instance.flags & ALPHA_TESTED) != 0u) {
        met = solid(index, Met(triangle, v, weights));
    }
    return met;
}

const int WALK_LIT = 0;
const int WALK_SHADOWED = 1;
const int WALK_LOST = 2;

// From the triangle of a sample's texel over the mesh, edge by edge, to what the light's ray to the sample meets: lit where the
// surface ends before, lost where it takes too long.
int walk(uint index, uint triangle, uint face, vec3 from, uvec2 own) {
    uint came = 0u;  // triangle + 1
    for (int i = 0; i < STEPS; i++) {
        vec3 weights;
        if (shadows(index, triangle, face, from, own, weights)) {
            return WALK_SHADOWED;
        }
        // seen edge-on it has no weights
        if (!(weights.x + weights.y + weights.z > 0.0)) {
            return WALK_LOST;
        }
        uint next = 0u;
        float least = 0.0;
        bool outside = false;
        for (int e = 0; e < 3; e++) {
            uint other = behind[3u * triangle + uint(e)];
            bool beyond = weights[e] < 0.0;
            // the surface folds over at the edge that was crossed
            if (beyond && other == came && came != 0u) {
                return WALK_LIT;
            }
            outside = outside || beyond;
            if (other != 0u && weights[e] < least) {
                least = weights[e];
                next = other;
            }
        }
        // it ends here, or lies behind the sample, or is cut away
        if (!outside || next == 0u) {
            return WALK_LIT;
        }
        came = triangle + 1u;
        triangle = next - 1u;
    }
    return WALK_LOST;
}

bool lit_by_stored(uint layer, uvec2 pixel, Sample s, Place p, Held held) {
    ivec2 middle = ivec2(p.texel);
    ivec2 last = textureSize(map, 0).xy - 1;
    uint face = face_of(layer);
    vec3 from = compared(face, ray_start(s.from_eye, s));
    uvec2 own = OWN ? texelFetch(owners, ivec2(pixel), 0).xy : uvec2(0u);
    int side = 2 * SEARCHED + 1;
    vec2 before = vec2(0.0);
    vec3 weights;
    for (int i = 0; i < side * side; i++) {
        ivec2 texel = clamp(middle + ivec2(i % side, i / side) - SEARCHED, ivec2(0), last);
        vec2 stored = texelFetch(second_map, ivec3(texel, layer), 0).rg;
        // neighbours often hold the same triangle
        if (stored != before && stored.y > 0.0 && shadows(uint(stored.x), uint(stored.y) - 1u, face, from, own, weights)) {
            return false;
        }
        before = stored;
    }
    vec2 stored = texelFetch(second_map, ivec3(middle, layer), 0).rg;
    if (UNCOVERED == UNCOVERED_LIT || stored.y == 0.0) {
        return true;
    }
    int found = WALK_LOST;
    if (UNCOVERED == UNCOVERED_WALK) {
        found = walk(uint(stored.x), uint(stored.y) - 1u, face, from, own);
    }
    return found == WALK_LIT || found == WALK_LOST && lit_by(layer, held, middle);
}
