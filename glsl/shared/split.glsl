// Positions relative to the eye, from coordinates in two parts. Needs structs.glsl and frame.glsl.

#include "shared/linear.glsl"

// From the eye to the place of an instance: exact but for one rounding of the result.
vec3 eye_to_instance(Frame frame, Instance instance) {
    vec3 high = vec3(instance.rows[0].w, instance.rows[1].w, instance.rows[2].w);
    precise vec3 far = high - frame.eye.xyz;
    precise vec3 rest = instance.low.xyz - frame.eye_low.xyz;
    return far + rest;
}
