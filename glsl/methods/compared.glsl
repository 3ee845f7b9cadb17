// Exact tests of samples against casters in light space. Needs methods/light.glsl.

// Where samples and casters are compared: the space of a face, relative to a light with a place and to the eye otherwise, so that
// nothing near it is rounded more than its distance asks for.
vec3 compared(uint face, vec3 from_eye) { return has_position() ? light_space(face, from_eye) : turned(face, from_eye); }

// Whether the caster with these corners lies between a sample and the light, and where the ray meets it. Space is sheared along
// the ray (Woop, Benthin and Wald 2013): neighbours compute the same edge function with opposite signs, so no ray slips through a
// shared edge. A caster seen edge-on is not met.
bool met_at(vec3 from, vec3 corner_a, vec3 corner_b, vec3 corner_c, out vec3 weights) {
    precise vec3 a = corner_a - from, b = corner_b - from, c = corner_c - from;
    if (has_position()) {
        precise vec2 slope = from.xy / from.z;
        a.xy -= slope * a.z;
        b.xy -= slope * b.z;
        c.xy -= slope * c.z;
    }
    precise float u = c.x * b.y - c.y * b.x;
    precise float v = a.x * c.y - a.y * c.x;
    precise float w = b.x * a.y - b.y * a.x;
    float determinant = u + v + w;
    bool inside = (min(min(u, v), w) >= 0.0 || max(max(u, v), w) <= 0.0) && determinant != 0.0;
    weights = vec3(u, v, w) / determinant;
    float z = dot(weights, vec3(a.z, b.z, c.z));
    return inside && z < 0.0 && (!has_position() || z > -from.z);
}
