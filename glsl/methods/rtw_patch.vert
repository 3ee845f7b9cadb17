#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/structs.glsl"
#include "methods/fit.glsl"
#include "methods/map_place.glsl"
#include "methods/rtw_vertex.glsl"

// Corners of triangles to be subdivided: where the fit without a warp has them.
layout(location = 4) out vec3 place;

void main() { place = caster().xyw; }
