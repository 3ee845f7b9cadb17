#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_ARB_shader_viewport_layer_array : require
#include "shared/structs.glsl"
#include "methods/fit.glsl"
#include "methods/map_vertex.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec2 uv;
layout(location = 2) in vec4 color;
layout(location = 0) out vec2 frag_uv;
layout(location = 1) out vec4 frag_color;
layout(location = 2) flat out uint material;
layout(location = 3) flat out uint mirrored;

void main() {
    frag_uv = uv;
    frag_color = color;
    Instance instance;
    uint layer;
    place_vertex(position, instance, layer);
    material = instance.material;
    mirrored = determinant(mat3(instance.rows[0].xyz, instance.rows[1].xyz, instance.rows[2].xyz)) < 0.0 ? 1u : 0u;
    mirrored |= layer << 1;
}
