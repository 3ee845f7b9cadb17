#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/structs.glsl"

// Triangles asked where the centre of a texel lies without the warp.
#define FETCH_BINDING 8
#include "methods/bent_fragment.glsl"
#define CENTRES_BINDING 7
#include "methods/rtw_centres.glsl"

vec2 centre_of(uvec2 texel, out float w) {
    w = 1.0;
    return vec2(texel_centre(0u, texel.x), texel_centre(1u, texel.y));
}
