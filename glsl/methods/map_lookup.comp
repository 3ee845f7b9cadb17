#version 460
#extension GL_GOOGLE_include_directive : require
#include "methods/map_lookup.glsl"

// Texels are those of the fit.
Place placed(vec2 uv, float side) {
    vec2 texel = uv * side;
    return Place(texel, floor(texel) + 0.5, vec2(1.0));
}
