#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/structs.glsl"

// Fixes how many requests are sorted and the dispatch size that follows from it.
layout(local_size_x = 1) in;
layout(constant_id = 0) const uint BLOCK = 512u;
layout(std430, binding = 0) buffer CountersBlock { Counters counters; };
layout(std430, binding = 1) writeonly buffer Arguments { uint arguments[]; };
layout(push_constant) uniform Push {
    uint capacity;
    uint argument;  // first word of the dispatch arguments
};

void main() {
    // the attempt that counts is the last; one that never ran has counted nothing
    uint count = counters.requests[0];
    for (uint attempt = 1u; attempt < 4u; attempt++) {
        if (counters.requests[attempt] > 0u) {
            count = counters.requests[attempt];
        }
    }
    count = min(count, capacity);
    counters.sorted = count;
    arguments[argument] = (count + BLOCK - 1u) / BLOCK;
    arguments[argument + 1u] = 1u;
    arguments[argument + 2u] = 1u;
}
