#version 460
#extension GL_GOOGLE_include_directive : require
#include "methods/fit.glsl"

// Turns and moves a map's texel grid (Scherzer et al. 2007; book, 4.7): another one for each frame, that still holds all samples.
layout(local_size_x = 1) in;
layout(std430, binding = 0) buffer Fits { Fit fits[]; };
layout(push_constant) uniform Push {
    vec2 turn;   // cosine and sine, divided by what makes room for the corners
    vec2 shift;  // share of the map
};

void main() {
    Fit fit = fits[0];
    vec3 u = fit.row_u.xyz - 0.5 * fit.row_w.xyz;
    vec3 v = fit.row_v.xyz - 0.5 * fit.row_w.xyz;
    fits[0].row_u.xyz = turn.x * u - turn.y * v + (0.5 + shift.x) * fit.row_w.xyz;
    fits[0].row_v.xyz = turn.y * u + turn.x * v + (0.5 + shift.y) * fit.row_w.xyz;
    vec2 size = fit.texel.xy / dot(turn, turn);
    fits[0].texel.xy = vec2(length(turn * size), length(turn.yx * size));
}
