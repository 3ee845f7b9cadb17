#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/morton.glsl"

// How many runs of equal keys begin in a block of 512 sorted keys; and, for the whole list, how many distinct keys
// would be left if all were coarsened.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint BLOCK = 512u;
layout(constant_id = 1) const int SHIFT_1 = 2;
layout(constant_id = 2) const int SHIFT_2 = 5;
layout(constant_id = 3) const int SHIFT_3 = 23;
layout(std430, binding = 0) buffer CountersBlock { Counters counters; };
layout(std430, binding = 1) readonly buffer Keys { uvec2 keys[]; };
layout(std430, binding = 2) writeonly buffer Heads { uint heads[]; };

shared uint sums[4];

void main() {
    uint local = gl_LocalInvocationIndex;
    if (local < 4u) {
        sums[local] = 0u;
    }
    barrier();
    uint end = min(counters.sorted, (gl_WorkGroupID.x + 1u) * BLOCK);
    for (uint i = gl_WorkGroupID.x * BLOCK + local; i < end; i += 64u) {
        uvec2 key = keys[i];
        uvec2 before = i > 0u ? keys[i - 1u] : uvec2(0u);
        if (key != before) {
            atomicAdd(sums[0], 1u);
            if (i == 0u || morton_ancestor(key, SHIFT_1) != morton_ancestor(before, SHIFT_1)) {
                atomicAdd(sums[1], 1u);
            }
            if (i == 0u || morton_ancestor(key, SHIFT_2) != morton_ancestor(before, SHIFT_2)) {
                atomicAdd(sums[2], 1u);
            }
            if (i == 0u || morton_ancestor(key, SHIFT_3) != morton_ancestor(before, SHIFT_3)) {
                atomicAdd(sums[3], 1u);
            }
        }
    }
    barrier();
    if (local == 0u) {
        heads[gl_WorkGroupID.x] = sums[0];
    }
    if (local < 4u) {
        atomicAdd(counters.unique[local], sums[local]);
    }
}
