#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/light.glsl"
#include "shared/refine.glsl"

// Ranks of every inner node as the least on its path to the root, so that the nodes above a threshold are always
// connected; roots have ranks of their own. The histograms add up what each rank would cost.
layout(local_size_x = 256) in;
layout(constant_id = 0) const uint NODE_CAPACITY = 1024u;
layout(constant_id = 1) const uint TABLE_SIZE = 1024u;
layout(std430, binding = 0) readonly buffer CountersBlock { Counters counters; };
layout(std430, binding = 1) buffer Nodes { Node nodes[]; };
layout(std430, binding = 2) readonly buffer NodeList { uint node_list[]; };
layout(std430, binding = 3) buffer Histogram { int histogram[]; };  // layers, then draws of each rank
layout(std430, binding = 4) readonly buffer TableKeys { uint table_keys[]; };
layout(std430, binding = 5) readonly buffer Lights { Light lights[]; };

#include "shared/table.glsl"

void main() {
    uint end = min(counters.leaves + counters.nodes, NODE_CAPACITY);
    for (uint i = gl_GlobalInvocationID.x; i < end; i += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
        uint slot = node_list[i];
        Node node = nodes[slot];
        uvec2 key = table_key(slot);
        if (key_level(key) == ROOT_LEVEL) {
            uint rank = root_rank(key, node, lights[key_face(key) / FACES].kind.x == LIGHT_DIRECTIONAL);
            atomicAdd(histogram[rank], page_layers(node.marks));
            atomicAdd(histogram[ALL_RANKS + rank], page_draws(node.slot, node.marks));
        }
        if (node.cost == 0u) {
            continue;
        }
        uint cost = node.cost;
        uint rank = RANKS - 1u;
        uint draw_rank = RANKS - 1u;
        for (int step = 0; step <= ROOT_LEVEL; step++) {
            rank = min(rank, cost_rank(node.cost));
            // the highest rank is kept for what draws nothing
            draw_rank = cost_draws(node.cost) > 0 ? min(draw_rank, min(cost_rank(node.cost), RANKS - 2u)) : draw_rank;
            if (node.parent == 0u) {
                break;
            }
            key = table_key(node.parent - 1u);
            node = nodes[node.parent - 1u];
        }
        if (key_level(key) < ROOT_LEVEL) {
            rank = 0u;  // an ancestor is missing because the table was full
        }
        nodes[slot].ranks = rank | draw_rank << 16;
        atomicAdd(histogram[rank], cost_layers(cost));
        atomicAdd(histogram[ALL_RANKS + rank], cost_draws(cost));
    }
}
