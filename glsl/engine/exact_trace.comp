#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/structs.glsl"

// Traces listed rays: 1 where nothing is met, 0 where a caster is.
#define RAY_BINDING 3
#include "shared/ray.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Count { uint count; };
layout(std430, binding = 1) readonly buffer Rays { vec4 rays[]; };  // two each: origin and t_max, direction
layout(std430, binding = 2) writeonly buffer Visibility { uint visibility[]; };
layout(push_constant) uniform Push { uint capacity; };

void main() {
    uint index = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationIndex;
    if (index >= min(count, capacity)) {
        return;
    }
    vec4 origin = rays[2u * index];
    visibility[index] = occluded(origin.xyz, rays[2u * index + 1u].xyz, origin.w) ? 0u : 1u;
}
