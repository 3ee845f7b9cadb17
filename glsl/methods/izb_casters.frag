#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/split.glsl"
#include "methods/fit.glsl"
#include "methods/izb_casters.glsl"
#define IZB_BINDING 9
#include "methods/izb.glsl"
layout(constant_id = 8) const bool OWN = false;  // whether `owners` are there
layout(binding = 12) uniform usampler2D owners;  // see izb_owner.glsl
layout(constant_id = 9) const bool TRANSLUCENT = false;  // whether casters may let a share of the light through
#define HELD_BACK_BINDING 13
#include "methods/izb_held_back.glsl"

// Tests each sample of a texel against a caster, exactly. The order of casters and of samples changes nothing.
layout(location = 0) flat in vec3 corner_a;
layout(location = 1) flat in vec3 corner_b;
layout(location = 2) flat in vec3 corner_c;
layout(location = 3) flat in uint instance_index;
layout(location = 4) flat in uint triangle;

// Whether the caster lies between a sample and the light, and where the ray meets it. Space is sheared along the ray (Woop, Benthin
// and Wald 2013): neighbours compute the same edge function with opposite signs, so no ray slips through a shared edge. A caster
// seen edge-on is not met.
bool met_at(vec3 from, out vec3 weights) {
    precise vec3 a = corner_a - from, b = corner_b - from, c = corner_c - from;
    if (has_position()) {
        precise vec2 slope = from.xy / from.z;
        a.xy -= slope * a.z;
        b.xy -= slope * b.z;
        c.xy -= slope * c.z;
    }
    precise float u = c.x * b.y - c.y * b.x;
    precise float v = a.x * c.y - a.y * c.x;
    precise float w = b.x * a.y - b.y * a.x;
    float determinant = u + v + w;
    bool inside = (min(min(u, v), w) >= 0.0 || max(max(u, v), w) <= 0.0) && determinant != 0.0;
    weights = vec3(u, v, w) / determinant;
    float z = dot(weights, vec3(a.z, b.z, c.z));
    return inside && z < 0.0 && (!has_position() || z > -from.z);
}

void main() {
    uvec2 texel = uvec2(gl_FragCoord.xy);
    uint next = heads[(LAYER * SIDE + texel.y) * SIDE + texel.x];
    while (next != 0u) {
        uint number = next - 1u;
        uvec4 s = listed[number];
        next = s.w;
        vec3 weights;
        bool met = met_at(uintBitsToFloat(s.xyz), weights);
        if (met && OWN) {
            // what a sample lies on does not shadow it
            uint pixel = number / SAMPLES;
            uvec2 owner = texelFetch(owners, ivec2(pixel % frame.size.x, pixel / frame.size.x), 0).xy;
            met = owner != uvec2(instance_index, triangle + 1u);
        }
        if (met && ALPHA) {
            uvec3 vertices = uvec3(indices[3u * triangle], indices[3u * triangle + 1u], indices[3u * triangle + 2u]);
            Met point = Met(triangle, vertices, weights);
            Material material = materials[instances[instance_index].material];
            if (TRANSLUCENT && material.translucent == 1u) {
                met = hold_back(number, alpha_of(material, point));
            } else {
                met = solid(instance_index, point);
            }
        }
        if (met) {
            atomicOr(shadowed[number / SAMPLES], 1u << (number % SAMPLES));
        }
    }
}
