#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/structs.glsl"

// Exclusive prefix sum, in place, by one workgroup, of `rows` values for each block of sorted entries.
layout(local_size_x = 256) in;
layout(constant_id = 0) const uint BLOCK = 512u;
layout(std430, binding = 0) buffer CountersBlock { Counters counters; };
layout(std430, binding = 1) buffer Values { uint values[]; };
layout(push_constant) uniform Push { uint rows; };

shared uint sums[256];

void main() {
    uint local = gl_LocalInvocationIndex;
    uint n = rows * ((counters.sorted + BLOCK - 1u) / BLOCK);
    uint share = (n + 255u) / 256u;
    uint begin = min(local * share, n);
    uint end = min(begin + share, n);
    uint sum = 0u;
    for (uint i = begin; i < end; i++) {
        sum += values[i];
    }
    sums[local] = sum;
    barrier();
    for (uint step = 1u; step < 256u; step *= 2u) {
        uint before = local >= step ? sums[local - step] : 0u;
        barrier();
        sums[local] += before;
        barrier();
    }
    sum = sums[local] - sum;
    for (uint i = begin; i < end; i++) {
        uint value = values[i];
        values[i] = sum;
        sum += value;
    }
}
