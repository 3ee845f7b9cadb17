#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/structs.glsl"

// The second surface that the light meets: what lies behind the first map's.
#define MATERIALS_BINDING 4
#define TEXELS_BINDING 5
#include "shared/masked_fragment.glsl"
layout(binding = 6) uniform sampler2DArray first;

void main() {
    // depth is the greater the nearer; triangles that share an edge round its depth alike but for a few units
    float nearest = texelFetch(first, ivec3(gl_FragCoord.xy, mirrored >> 1), 0).r;
    if (left_out() || gl_FragCoord.z >= nearest * (1.0 - 1e-6)) {
        discard;
    }
}
