// How far a kept page is from one drawn for the light as it is now. Needs `frame`.

// Texels of level 0 by which turned axes move the farthest caster.
float drift(Slot slot) {
    vec3 x = abs(vec3(slot.axis_x[0], slot.axis_x[1], slot.axis_x[2]) - frame.light_x.xyz);
    vec3 z = abs(vec3(slot.axis_z[0], slot.axis_z[1], slot.axis_z[2]) - frame.light_z.xyz);
    return frame.drift.x * (length(x) + length(z));
}
