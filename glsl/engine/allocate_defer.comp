#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/light.glsl"
#include "shared/refine.glsl"

// More must be drawn than the budget allows: adds up the draws by the rank that decides about them, then, within the rank
// at which the budget ends, by the order of the nodes.
layout(local_size_x = 256) in;
layout(constant_id = 0) const uint NODE_CAPACITY = 1024u;
layout(constant_id = 1) const uint TABLE_SIZE = 1024u;
layout(std430, binding = 0) readonly buffer CountersBlock { Counters counters; };
layout(std430, binding = 1) readonly buffer Nodes { Node nodes[]; };
layout(std430, binding = 2) readonly buffer NodeList { uint node_list[]; };
layout(std430, binding = 3) buffer Histogram { int histogram[]; };
layout(std430, binding = 4) readonly buffer TableKeys { uint table_keys[]; };
layout(std430, binding = 5) readonly buffer Lights { Light lights[]; };
layout(push_constant) uniform Push {
    int draw_budget;
    uint step;  // 1: by rank, 2: by order
};

#include "shared/table.glsl"

void defer(uint rank, uvec2 key, int draws) {
    if (step == 1u) {
        atomicAdd(histogram[2u * ALL_RANKS + rank], draws);
    } else if (rank + 1u == counters.draw_threshold) {
        atomicAdd(histogram[3u * ALL_RANKS + draw_order(key)], draws);
    }
}

void main() {
    if (int(counters.draws_asked) <= draw_budget) {
        return;
    }
    uint end = min(counters.leaves + counters.nodes, NODE_CAPACITY);
    for (uint i = gl_GlobalInvocationID.x; i < end; i += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
        uint slot = node_list[i];
        Node node = nodes[slot];
        uvec2 key = table_key(slot);
        if (key_level(key) == ROOT_LEVEL) {
            uint rank = root_rank(key, node, lights[key_face(key) / FACES].kind.x == LIGHT_DIRECTIONAL);
            int draws = page_draws(node.slot, node.marks);
            if (rank >= counters.threshold && draws > 0) {
                defer(rank, key, draws);
            }
        }
        if (fits(node, counters.threshold)) {
            defer(node.ranks >> 16, key, cost_draws(node.cost));
        }
    }
}
