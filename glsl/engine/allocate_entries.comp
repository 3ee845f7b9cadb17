#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"

// Bakes the fallback into the page table: every node's entry names its own page or its nearest ancestor's.
// Entry: bit 31 valid, bits 16-19 level of the serving page, bits 0-15 layer of the atlas.
layout(local_size_x = 256) in;
layout(constant_id = 0) const uint NODE_CAPACITY = 1024u;
layout(std430, binding = 0) buffer CountersBlock { Counters counters; };
layout(std430, binding = 1) readonly buffer Nodes { Node nodes[]; };
layout(std430, binding = 2) readonly buffer NodeList { uint node_list[]; };
layout(std430, binding = 3) readonly buffer Pages { Page pages[]; };
layout(std430, binding = 4) writeonly buffer Entries { uint entries[]; };
layout(push_constant) uniform Push {
    int tolerance;  // levels by which a request may be served coarser before it counts as refused
};

void main() {
    uint end = min(counters.leaves + counters.nodes, NODE_CAPACITY);
    for (uint i = gl_GlobalInvocationID.x; i < end; i += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
        uint slot = node_list[i];
        Node node = nodes[slot];
        int asked = key_level(node.key);
        for (int step = 0; step < ROOT_LEVEL; step++) {
            if ((node.page != 0u && pages[node.page - 1u].admitted != 0u) || node.parent == 0u) {
                break;
            }
            node = nodes[node.parent - 1u];
        }
        bool served = node.page != 0u && pages[node.page - 1u].admitted != 0u;
        int level = key_level(node.key);
        entries[slot] = served ? 0x80000000u | uint(level) << 16 | pages[node.page - 1u].slot : 0u;
        if (i < counters.leaves) {
            atomicAdd(counters.requested[asked], 1u);
            if (!served || level > asked - int(counters.shift) + tolerance) {
                atomicAdd(counters.refused[asked], 1u);
            }
        }
    }
}
