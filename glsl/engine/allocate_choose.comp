#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/refine.glsl"

// Finds the least rank whose nodes, with all of higher rank, can be refined within the atlas. One workgroup.
layout(local_size_x = 256) in;
layout(std430, binding = 0) buffer CountersBlock { Counters counters; };
layout(std430, binding = 1) readonly buffer Histogram { uint histogram[]; };
layout(push_constant) uniform Push { uint budget; };

shared uint sums[256];
shared uint least;

void main() {
    uint local = gl_LocalInvocationIndex;
    const uint share = RANKS / 256u;
    uint sum = 0u;
    for (uint i = 0u; i < share; i++) {
        sum += histogram[RANKS - 1u - (local * share + i)];
    }
    sums[local] = sum;
    if (local == 0u) {
        least = RANKS;
    }
    barrier();
    for (uint step = 1u; step < 256u; step *= 2u) {
        uint before = local >= step ? sums[local - step] : 0u;
        barrier();
        sums[local] += before;
        barrier();
    }
    sum = sums[local] - sum;
    for (uint i = 0u; i < share; i++) {
        uint rank = RANKS - 1u - (local * share + i);
        sum += histogram[rank];
        if (sum <= budget && rank > 0u) {
            atomicMin(least, rank);
        }
    }
    barrier();
    if (local == 0u) {
        counters.threshold = least;
    }
}
