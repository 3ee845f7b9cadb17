#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/structs.glsl"

// Radix sort, step 1 of a pass: how often each 4-bit digit occurs in a block of 512 keys.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint BLOCK = 512u;
layout(std430, binding = 0) readonly buffer CountersBlock { Counters counters; };
layout(std430, binding = 1) readonly buffer Keys { uvec2 keys[]; };
layout(std430, binding = 2) writeonly buffer Histogram { uint histogram[]; };
layout(push_constant) uniform Push { uint digit; };  // its first bit; from 32 on in the first word

#include "shared/digit.glsl"

shared uint bins[16];

void main() {
    uint local = gl_LocalInvocationIndex;
    if (local < 16u) {
        bins[local] = 0u;
    }
    barrier();
    uint end = min(counters.sorted, (gl_WorkGroupID.x + 1u) * BLOCK);
    for (uint i = gl_WorkGroupID.x * BLOCK + local; i < end; i += 64u) {
        atomicAdd(bins[digit_of(keys[i])], 1u);
    }
    barrier();
    if (local < 16u) {
        histogram[local * gl_NumWorkGroups.x + gl_WorkGroupID.x] = bins[local];
    }
}
