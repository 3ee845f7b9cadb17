#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_ARB_shader_viewport_layer_array : require
#include "shared/structs.glsl"
#include "methods/fit.glsl"
#include "methods/map_vertex.glsl"

layout(location = 0) in vec3 position;

void main() {
    Instance instance;
    uint layer;
    place_vertex(position, instance, layer);
}
