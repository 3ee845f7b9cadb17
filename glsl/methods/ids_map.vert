#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_ARB_shader_viewport_layer_array : require
#include "shared/structs.glsl"
#include "methods/fit.glsl"
#include "methods/map_vertex.glsl"
#include "methods/ids_vertex.glsl"

// Casters in one layer of a map, with the numbers of their triangles.
void main() {
    Instance instance;
    uint layer;
    place_vertex(fetch_vertex(instances[gl_InstanceIndex]), instance, layer);
}
