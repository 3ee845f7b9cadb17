// How far a kept page is from one drawn for the light as it is now. Needs light.glsl.

// Units * texels by which turned axes move the farthest caster of a directional light.
float drift(Light light, Slot slot) {
    if (light.kind.x != LIGHT_DIRECTIONAL) {
        return 0.0;
    }
    vec3 x = abs(vec3(slot.axis_x[0], slot.axis_x[1], slot.axis_x[2]) - light.axis_x.xyz);
    vec3 z = abs(vec3(slot.axis_z[0], slot.axis_z[1], slot.axis_z[2]) - light.axis_z.xyz);
    return light.rule.z * (length(x) + length(z));
}
