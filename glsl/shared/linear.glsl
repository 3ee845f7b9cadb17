// Directions of instances. Needs structs.glsl.

// A vector of mesh space in world space.
vec3 linear(Instance instance, vec3 v) { return vec3(dot(instance.rows[0].xyz, v), dot(instance.rows[1].xyz, v), dot(instance.rows[2].xyz, v)); }
