#version 460
#extension GL_GOOGLE_include_directive : require
#define RESIZED
#include "methods/map_sampling.glsl"

// Through a rectilinear warp (Rosen 2012): a cell's texels are as many as its share of the map.
#define CELLS_CONSTANT 7
#define WARP_BINDING 8
#include "methods/rtw.glsl"

uint part_of(uint layer, vec2 uv) { return layer; }
vec2 texels_of(vec2 uv) { return vec2(growth(0u, uv.x), growth(1u, uv.y)); }
