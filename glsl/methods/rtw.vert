#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_ARB_shader_viewport_layer_array : require
#include "shared/structs.glsl"
#include "methods/fit.glsl"
#include "methods/map_place.glsl"

// Warped vertices with straight edges between them (Rosen 2012, 4.3).
#define CELLS_CONSTANT 3
#define WARP_BINDING 6
#include "methods/rtw.glsl"
#include "methods/rtw_vertex.glsl"

void main() {
    vec4 place = caster();
    gl_Position = vec4(2.0 * warped(place.xy) - 1.0, place.w, 1.0);
}
