#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/refine.glsl"

// More must be drawn than the budget allows: adds up the draws by the rank that decides about them.
layout(local_size_x = 256) in;
layout(constant_id = 0) const uint NODE_CAPACITY = 1024u;
layout(std430, binding = 0) readonly buffer CountersBlock { Counters counters; };
layout(std430, binding = 1) readonly buffer Nodes { Node nodes[]; };
layout(std430, binding = 2) readonly buffer NodeList { uint node_list[]; };
layout(std430, binding = 3) buffer Histogram { int histogram[]; };
layout(push_constant) uniform Push { uint budget; };

void main() {
    if (counters.draws_asked <= budget) {
        return;
    }
    uint end = min(counters.leaves + counters.nodes, NODE_CAPACITY);
    for (uint i = gl_GlobalInvocationID.x; i < end; i += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
        Node node = nodes[node_list[i]];
        if (refined(node, counters.threshold, 0u)) {
            atomicAdd(histogram[2u * RANKS + (node.ranks >> 16)], cost_draws(node.cost));
        }
    }
}
