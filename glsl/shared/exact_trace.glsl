// Traces listed rays from receivers: 1 where nothing is met, 0 where a caster is. Receivers whose pixel is so small that the
// depth of large triangles does not tell on which side of them they lie are first moved onto the nearest surface. Needs
// `frame` and `occluded` of ray.glsl or ray_query.glsl.
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Count { uint count; };
layout(std430, binding = 1) readonly buffer Rays { vec4 rays[]; };  // two each: receiver and t_max, direction and packed normal
layout(std430, binding = 2) writeonly buffer Visibility { uint visibility[]; };
layout(push_constant) uniform Push { uint capacity; };

void main() {
    uint index = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationIndex;
    if (index >= min(count, capacity)) {
        return;
    }
    vec3 receiver = rays[2u * index].xyz;
    float t_max = rays[2u * index].w;
    vec3 direction = rays[2u * index + 1u].xyz;
    float offset = ray_offset(frame, receiver);
    Surface surface = Surface(0u, NO_TRIANGLE, 0.0);
    // twice around one walk: two would be twice the code
    bool met = false;
    for (uint step = offset < frame.rule.w ? 0u : 1u; step < 2u; step++) {
        bool snap = step == 0u;
        vec3 start = receiver;
        if (!snap) {
            vec3 shift = surface.t * receiver + offset * decode_normal(floatBitsToUint(rays[2u * index + 1u].w));
            start += shift;
            // rays that end do so at a light
            direction -= t_max == 1.0 ? shift : vec3(0.0);
        }
        met = occluded(start, snap ? receiver : direction, t_max, snap ? SNAP : 0.0, surface);
    }
    visibility[index] = met ? 0u : 1u;
}
