#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/refine.glsl"

// The pages to draw: the cut through the quadtree below the refined nodes, refined nodes that some pixels ask for
// themselves, and the roots.
layout(local_size_x = 256) in;
layout(constant_id = 0) const uint NODE_CAPACITY = 1024u;
layout(constant_id = 1) const uint PAGE_CAPACITY = 1024u;
layout(std430, binding = 0) buffer CountersBlock { Counters counters; };
layout(std430, binding = 1) readonly buffer Nodes { Node nodes[]; };
layout(std430, binding = 2) readonly buffer NodeList { uint node_list[]; };
layout(std430, binding = 3) writeonly buffer Keys { uint keys[]; };
layout(std430, binding = 4) writeonly buffer Values { uint values[]; };

// Whether a node is replaced by its children.
bool refined(Node node) {
    uint rank = node.ranks >> 16;
    bool drawn = rank >= counters.draw_threshold || (rank + 1u == counters.draw_threshold && draw_order(node.key) < counters.draw_order);
    return drawn && fits(node, counters.threshold);
}

bool selected(Node node) {
    if (key_level(node.key) == ROOT_LEVEL) {
        return true;
    }
    if (node.parent == 0u || !refined(nodes[node.parent - 1u])) {
        return false;
    }
    return !refined(node) || node.own > 0u;
}

void main() {
    uint end = min(counters.leaves + counters.nodes, NODE_CAPACITY);
    for (uint i = gl_GlobalInvocationID.x; i < end; i += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
        uint slot = node_list[i];
        if (selected(nodes[slot])) {
            uint index = atomicAdd(counters.pages, 1u);
            if (index < PAGE_CAPACITY) {
                keys[index] = nodes[slot].key;
                values[index] = slot;
            }
        }
    }
}
