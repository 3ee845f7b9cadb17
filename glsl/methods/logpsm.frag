#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/structs.glsl"
#include "methods/fit.glsl"
layout(std430, binding = 1) readonly buffer Fits { Fit fits[]; };

// Triangles asked where the centre of a texel lies before the logarithm (book, 4.2.4), in the coordinates of logpsm.vert.
#define FETCH_BINDING 6
#include "methods/bent_fragment.glsl"

vec2 centre_of(uvec2 texel, out float w) {
    vec2 centre = (vec2(texel) + 0.5) / float(SIDE);
    w = logarithmic(fits[0]) ? exp2(centre.y / fits[0].texel.z) : 1.0;
    return logarithmic(fits[0]) ? vec2(centre.x * w, w) : centre;
}
