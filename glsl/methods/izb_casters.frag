#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/split.glsl"
#include "methods/fit.glsl"
#include "methods/izb_casters.glsl"
#define IZB_BINDING 9
#include "methods/izb.glsl"
#include "methods/compared.glsl"
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

void main() {
    uvec2 texel = uvec2(gl_FragCoord.xy);
    uint next = heads[(LAYER * SIDE + texel.y) * SIDE + texel.x];
    while (next != 0u) {
        uint number = next - 1u;
        uvec4 s = listed[number];
        next = s.w;
        vec3 weights;
        bool met = met_at(uintBitsToFloat(s.xyz), corner_a, corner_b, corner_c, weights);
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
