#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/structs.glsl"

// Writes each distinct key once and adds up its pixel counts.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint BLOCK = 512u;
layout(std430, binding = 0) readonly buffer CountersBlock { Counters counters; };
layout(std430, binding = 1) readonly buffer Keys { uvec2 keys[]; };
layout(std430, binding = 2) readonly buffer Values { uint values[]; };
layout(std430, binding = 3) readonly buffer Heads { uint heads[]; };
layout(std430, binding = 4) writeonly buffer Unique { uvec2 unique_keys[]; };
layout(std430, binding = 5) buffer UniqueCounts { uint unique_counts[]; };

shared uint sums[64];

bool head(uint i) { return i == 0u || keys[i] != keys[i - 1u]; }

void main() {
    uint local = gl_LocalInvocationIndex;
    uint share = BLOCK / 64u;
    uint begin = min(gl_WorkGroupID.x * BLOCK + local * share, counters.sorted);
    uint end = min(begin + share, counters.sorted);
    uint count = 0u;
    for (uint i = begin; i < end; i++) {
        count += head(i) ? 1u : 0u;
    }
    sums[local] = count;
    barrier();
    for (uint step = 1u; step < 64u; step *= 2u) {
        uint before = local >= step ? sums[local - step] : 0u;
        barrier();
        sums[local] += before;
        barrier();
    }
    uint index = heads[gl_WorkGroupID.x] + sums[local] - count;
    for (uint i = begin; i < end; i++) {
        if (head(i)) {
            unique_keys[index] = keys[i];
            index++;
        }
        // a run that began in an earlier thread's share continues its entry
        atomicAdd(unique_counts[index - 1u], values[i]);
    }
}
