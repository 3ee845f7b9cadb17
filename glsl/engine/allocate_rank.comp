#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/refine.glsl"

// What refining a node gains for the layers of the atlas it costs, and how many layers it makes draw.
layout(local_size_x = 256) in;
layout(constant_id = 0) const uint NODE_CAPACITY = 1024u;
layout(constant_id = 1) const uint TABLE_SIZE = 1024u;
layout(constant_id = 2) const uint PRESSURE = 0u;  // which nodes give way: 2: those of the finest levels
layout(std430, binding = 0) readonly buffer CountersBlock { Counters counters; };
layout(std430, binding = 1) buffer Nodes { Node nodes[]; };
layout(std430, binding = 2) readonly buffer NodeList { uint node_list[]; };
layout(std430, binding = 3) readonly buffer TableKeys { uint table_keys[]; };

#include "shared/table.glsl"

void main() {
    uint end = min(counters.leaves + counters.nodes, NODE_CAPACITY);
    for (uint i = gl_GlobalInvocationID.x; i < end; i += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
        uint slot = node_list[i];
        Node node = nodes[slot];
        int layers = 0;
        int draws = 0;
        for (uint q = 0u; q < 4u; q++) {
            if (node.child[q] != 0u) {
                uint child = node.child[q] - 1u;
                uint marks = nodes[child].marks;
                layers += page_layers(marks);
                draws += page_draws(nodes[child].slot, marks);
            }
        }
        if (layers == 0) {
            continue;
        }
        // its own page goes when no pixel needs that any more; roots always stay
        int level = key_level(table_key(slot));
        if (node.own == 0u && level < ROOT_LEVEL) {
            layers -= page_layers(node.marks);
            draws -= page_draws(node.slot, node.marks);
        }
        // what costs no layer always goes on
        uint rank = PRESSURE == 2u && layers > 0 ? 64u * uint(level) : refine_rank(node.below / 2u, layers);
        nodes[slot].cost = cost_of(rank, draws, layers);
    }
}
