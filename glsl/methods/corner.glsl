// Corners of casters where they are compared with samples. Needs methods/compared.glsl, shared/split.glsl and shared/position.glsl.

// Bit for bit the same for all triangles that share a vertex.
vec3 corner_at(uint face, Instance instance, uint vertex) {
    precise vec3 from_eye = eye_to_instance(frame, instance) + linear(instance, position(vertex));
    precise vec3 at = compared(face, from_eye);
    return at;
}
