// A caster's vertex with what a test of its fragments needs.
layout(location = 0) in vec3 position;
layout(location = 1) in vec2 uv;
layout(location = 2) in vec4 color;
layout(location = 0) out vec2 vertex_uv;
layout(location = 1) out vec4 vertex_color;
layout(location = 2) flat out uint material;
layout(location = 3) flat out uint mirrored;

// As map_place().
vec4 caster() {
    Instance instance = instances[gl_InstanceIndex];
    vertex_uv = uv;
    vertex_color = color;
    material = instance.material;
    mirrored = determinant(mat3(instance.rows[0].xyz, instance.rows[1].xyz, instance.rows[2].xyz)) < 0.0 ? 1u : 0u;
    return map_place(instance, position, 0u);
}
