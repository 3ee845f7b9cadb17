#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_ARB_shader_viewport_layer_array : require
#include "shared/structs.glsl"
#include "methods/fit.glsl"
#include "methods/map_vertex.glsl"

void main() {
    Instance instance;
    uint layer;
    place_vertex(instance, layer);
}
