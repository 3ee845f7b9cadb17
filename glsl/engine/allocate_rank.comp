#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/refine.glsl"

// Rank of every inner node: the least benefit per cost on its path to the root, so that a set of nodes above a
// threshold is always connected. The histogram adds up the pages that each rank would cost.
layout(local_size_x = 256) in;
layout(constant_id = 0) const uint NODE_CAPACITY = 1024u;
layout(std430, binding = 0) buffer CountersBlock { Counters counters; };
layout(std430, binding = 1) buffer Nodes { Node nodes[]; };
layout(std430, binding = 2) readonly buffer NodeList { uint node_list[]; };
layout(std430, binding = 3) buffer Histogram { uint histogram[]; };

void main() {
    uint end = min(counters.leaves + counters.nodes, NODE_CAPACITY);
    for (uint i = gl_GlobalInvocationID.x; i < end; i += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
        uint slot = node_list[i];
        Node node = nodes[slot];
        uint children = child_count(node);
        if (children == 0u) {
            continue;
        }
        uint cost = refine_cost(node, children);
        uint rank = refine_rank(node.below / 2u, cost);
        for (int step = 0; step < ROOT_LEVEL && node.parent != 0u; step++) {
            node = nodes[node.parent - 1u];
            rank = min(rank, refine_rank(node.below / 2u, refine_cost(node, child_count(node))));
        }
        if (key_level(node.key) < ROOT_LEVEL) {
            rank = 0u;  // an ancestor is missing because the table was full
        }
        nodes[slot].rank = rank;
        atomicAdd(histogram[rank], cost);
    }
}
