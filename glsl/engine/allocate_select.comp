#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/light.glsl"
#include "shared/refine.glsl"

// The pages that are to serve: the cut through the quadtrees below the refined nodes, refined nodes that some pixels ask
// for themselves, and the roots.
layout(local_size_x = 256) in;
layout(constant_id = 0) const uint NODE_CAPACITY = 1024u;
layout(constant_id = 1) const uint PAGE_CAPACITY = 1024u;
layout(constant_id = 2) const uint TABLE_SIZE = 1024u;
layout(std430, binding = 0) buffer CountersBlock { Counters counters; };
layout(std430, binding = 1) readonly buffer Nodes { Node nodes[]; };
layout(std430, binding = 2) readonly buffer NodeList { uint node_list[]; };
layout(std430, binding = 3) writeonly buffer Keys { uvec2 keys[]; };
layout(std430, binding = 4) writeonly buffer Values { uint values[]; };
layout(std430, binding = 5) readonly buffer TableKeys { uint table_keys[]; };
layout(std430, binding = 6) readonly buffer Lights { Light lights[]; };

#include "shared/table.glsl"

// Whether what has this rank among those that draw may be drawn.
bool drawn(uint rank, uvec2 key) {
    return rank >= counters.draw_threshold || (rank + 1u == counters.draw_threshold && draw_order(key) < counters.draw_order);
}

// Whether a node is replaced by its children.
bool refined(uint slot) {
    Node node = nodes[slot];
    return drawn(node.ranks >> 16, table_key(slot)) && fits(node, counters.threshold);
}

bool selected(uint slot) {
    Node node = nodes[slot];
    uvec2 key = table_key(slot);
    if (key_level(key) == ROOT_LEVEL) {
        uint rank = root_rank(key, node, lights[key_face(key) / FACES].kind.x == LIGHT_DIRECTIONAL);
        return rank >= counters.threshold && (page_draws(node.slot, node.marks) == 0 || drawn(rank, key));
    }
    if (node.parent == 0u || !refined(node.parent - 1u)) {
        return false;
    }
    return !refined(slot) || node.own > 0u;
}

void main() {
    uint end = min(counters.leaves + counters.nodes, NODE_CAPACITY);
    for (uint i = gl_GlobalInvocationID.x; i < end; i += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
        uint slot = node_list[i];
        if (selected(slot)) {
            uint index = atomicAdd(counters.pages, 1u);
            if (index < PAGE_CAPACITY) {
                keys[index] = table_key(slot);
                values[index] = slot;
            }
        }
    }
}
