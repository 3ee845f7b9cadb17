// Vertices fetched by hand, so that each triangle has a number of its own. Takes bindings 2 and 4 to 9; the includer puts the place.
layout(constant_id = 4) const uint POSITION_STRIDE = 3u;
layout(constant_id = 5) const uint POSITION_OFFSET = 0u;
layout(constant_id = 6) const uint POSITION_FORMAT = 0u;
layout(std430, binding = 6) readonly buffer Positions { uint positions[]; };
layout(std430, binding = 7) readonly buffer Indices { uint indices[]; };
layout(std430, binding = 8) readonly buffer Attributes { uint attributes[]; };  // three words a vertex
layout(std430, binding = 9) readonly buffer Bases { uint bases[]; };  // of each instance: its first number less its first triangle
#include "shared/position.glsl"

layout(location = 0) out vec2 frag_uv;
layout(location = 1) out vec4 frag_color;
layout(location = 2) flat out uint material;
layout(location = 3) flat out uint mirrored;
layout(location = 4) flat out float polygon;

// Writes all but the place; the vertex's position in its mesh.
vec3 fetch_vertex(Instance instance) {
    uint vertex = indices[gl_VertexIndex];
    frag_uv = vec2(uintBitsToFloat(attributes[3u * vertex]), uintBitsToFloat(attributes[3u * vertex + 1u]));
    frag_color = unpackUnorm4x8(attributes[3u * vertex + 2u]);
    material = instance.material;
    mirrored = determinant(mat3(instance.rows[0].xyz, instance.rows[1].xyz, instance.rows[2].xyz)) < 0.0 ? 1u : 0u;
    polygon = float(bases[gl_InstanceIndex] + uint(gl_VertexIndex) / 3u);
    return position(vertex);
}
