#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/refine.glsl"

// More must be drawn than the budget allows: adds up the draws by the rank that decides about them, then, within the rank
// at which the budget ends, by the order of the nodes.
layout(local_size_x = 256) in;
layout(constant_id = 0) const uint NODE_CAPACITY = 1024u;
layout(std430, binding = 0) readonly buffer CountersBlock { Counters counters; };
layout(std430, binding = 1) readonly buffer Nodes { Node nodes[]; };
layout(std430, binding = 2) readonly buffer NodeList { uint node_list[]; };
layout(std430, binding = 3) buffer Histogram { int histogram[]; };
layout(push_constant) uniform Push {
    int draw_budget;
    uint step;  // 1: by rank, 2: by order
};

void main() {
    if (int(counters.draws_asked) <= draw_budget) {
        return;
    }
    uint end = min(counters.leaves + counters.nodes, NODE_CAPACITY);
    for (uint i = gl_GlobalInvocationID.x; i < end; i += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
        Node node = nodes[node_list[i]];
        uint rank = node.ranks >> 16;
        if (!fits(node, counters.threshold)) {
            continue;
        }
        if (step == 1u) {
            atomicAdd(histogram[2u * RANKS + rank], cost_draws(node.cost));
        } else if (rank + 1u == counters.draw_threshold) {
            atomicAdd(histogram[3u * RANKS + draw_order(node.key)], cost_draws(node.cost));
        }
    }
}
