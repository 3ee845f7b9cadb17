#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_ARB_shader_viewport_layer_array : require
#include "shared/structs.glsl"
#include "methods/fit.glsl"
#include "methods/map_vertex.glsl"

// Casters in one layer of a map, with the numbers of their triangles: vertices are fetched by hand, so that each triangle has its own.
layout(constant_id = 4) const uint POSITION_STRIDE = 3u;
layout(constant_id = 5) const uint POSITION_OFFSET = 0u;
layout(constant_id = 6) const uint POSITION_FORMAT = 0u;
layout(std430, binding = 6) readonly buffer Positions { uint positions[]; };
layout(std430, binding = 7) readonly buffer Indices { uint indices[]; };
layout(std430, binding = 8) readonly buffer Attributes { uint attributes[]; };  // three words a vertex
#include "shared/position.glsl"

layout(location = 0) out vec2 frag_uv;
layout(location = 1) out vec4 frag_color;
layout(location = 2) flat out uint material;
layout(location = 3) flat out uint mirrored;
layout(location = 4) flat out vec2 triangle;

void main() {
    uint vertex = indices[gl_VertexIndex];
    Instance instance;
    uint layer;
    place_vertex(position(vertex), instance, layer);
    frag_uv = vec2(uintBitsToFloat(attributes[3u * vertex]), uintBitsToFloat(attributes[3u * vertex + 1u]));
    frag_color = unpackUnorm4x8(attributes[3u * vertex + 2u]);
    material = instance.material;
    mirrored = determinant(mat3(instance.rows[0].xyz, instance.rows[1].xyz, instance.rows[2].xyz)) < 0.0 ? 1u : 0u;
    triangle = vec2(gl_InstanceIndex, gl_VertexIndex / 3 + 1);
}
