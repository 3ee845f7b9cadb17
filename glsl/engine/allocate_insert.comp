#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/morton.glsl"

// Sort route: the distinct keys enter the page table, coarsened until they fit.
layout(local_size_x = 256) in;
layout(constant_id = 0) const uint TABLE_SIZE = 1024u;
layout(constant_id = 1) const uint CAPACITY = 1024u;
layout(constant_id = 2) const int SHIFT_1 = 2;
layout(constant_id = 3) const int SHIFT_2 = 5;
layout(constant_id = 4) const int SHIFT_3 = 23;
layout(std430, binding = 0) buffer CountersBlock { Counters counters; };
layout(std430, binding = 1) readonly buffer Unique { uvec2 unique_keys[]; };
layout(std430, binding = 2) readonly buffer UniqueCounts { uint unique_counts[]; };
layout(std430, binding = 3) buffer TableKeys { uint table_keys[]; };
layout(std430, binding = 4) buffer Nodes { Node nodes[]; };
layout(std430, binding = 5) writeonly buffer NodeList { uint node_list[]; };

#include "shared/table.glsl"
#include "shared/table_insert.glsl"

void main() {
    int shift = counters.unique[0] <= CAPACITY ? 0 : counters.unique[1] <= CAPACITY ? SHIFT_1 : counters.unique[2] <= CAPACITY ? SHIFT_2 : SHIFT_3;
    uint id = gl_GlobalInvocationID.x;
    if (id == 0u && shift > 0) {
        atomicAdd(counters.shift, uint(shift));
    }
    for (uint i = id; i < counters.unique[0]; i += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
        uvec2 key = key_ancestor(key_from_morton(unique_keys[i]), shift);
        bool fresh;
        uint slot = table_insert(key, fresh);
        if (slot == NONE) {
            atomicAdd(counters.failed, 1u);
            continue;
        }
        if (fresh) {
            node_list[atomicAdd(counters.leaves, 1u)] = slot;
        }
        atomicAdd(nodes[slot].own, unique_counts[i]);
    }
}
