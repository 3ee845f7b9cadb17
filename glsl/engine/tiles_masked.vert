#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_ARB_shader_viewport_layer_array : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/light.glsl"
#include "shared/tile_vertex.glsl"

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
    place_vertex(instance);
    material = instance.material;
    mirrored = determinant(mat3(instance.rows[0].xyz, instance.rows[1].xyz, instance.rows[2].xyz)) < 0.0 ? 1u : 0u;
}
