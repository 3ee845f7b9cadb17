#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/structs.glsl"

// Dispatch size of what follows for each run of clusters.
layout(local_size_x = 1) in;
layout(constant_id = 0) const uint DISPATCH_X = 32768u;
layout(std430, binding = 0) readonly buffer CountersBlock { Counters counters; };
layout(std430, binding = 1) writeonly buffer Arguments { uint arguments[]; };
layout(push_constant) uniform Push {
    uint layer;
    uint argument;  // first word of the dispatch arguments
};

void main() {
    uint groups = (counters.items[layer] * RUN + 63u) / 64u;
    arguments[argument] = min(groups, DISPATCH_X);
    arguments[argument + 1u] = (groups + DISPATCH_X - 1u) / DISPATCH_X;
    arguments[argument + 2u] = 1u;
}
