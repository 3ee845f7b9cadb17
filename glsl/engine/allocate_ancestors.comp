#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"

// Grows the quadtree above the requested pages: every ancestor up to the root level gets a node, its pixel weight and
// the links to its children. The four roots always exist.
layout(local_size_x = 256) in;
layout(constant_id = 0) const uint TABLE_SIZE = 1024u;
layout(constant_id = 1) const uint NODE_CAPACITY = 1024u;
layout(constant_id = 2) const int WEIGHT_BITS = 10;
layout(std430, binding = 0) buffer CountersBlock { Counters counters; };
layout(std430, binding = 1) buffer TableKeys { uint table_keys[]; };
layout(std430, binding = 2) buffer Nodes { Node nodes[]; };
layout(std430, binding = 3) buffer NodeList { uint node_list[]; };

#include "shared/table.glsl"
#include "shared/table_insert.glsl"

uint node_insert(uint key, out bool fresh) {
    uint slot = table_insert(key, fresh);
    if (slot == NONE) {
        atomicAdd(counters.failed, 1u);
    } else if (fresh) {
        nodes[slot].key = key;
        uint index = counters.leaves + atomicAdd(counters.nodes, 1u);
        if (index < NODE_CAPACITY) {
            node_list[index] = slot;
        } else {
            atomicAdd(counters.failed, 1u);
        }
    }
    return slot;
}

void main() {
    uint stride = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
    bool fresh;
    if (gl_GlobalInvocationID.x < 4u) {
        uint root = gl_GlobalInvocationID.x;
        counters.roots[root] = node_insert(key_of(ROOT_LEVEL, uvec2(root & 1u, root >> 1)), fresh) + 1u;
    }
    for (uint i = gl_GlobalInvocationID.x; i < counters.leaves; i += stride) {
        uint child = node_list[i];
        uint key = nodes[child].key;
        uint count = nodes[child].own;
        bool link = true;
        int distance = 1;
        while (key_level(key) < ROOT_LEVEL) {
            uint quadrant = key & 3u;
            key = key_ancestor(key, 1);
            uint slot = node_insert(key, fresh);
            if (slot == NONE) {
                break;
            }
            if (link) {
                nodes[slot].child[quadrant] = child + 1u;
                nodes[child].parent = slot + 1u;
            }
            // a pixel that is d levels short of its wish errs by 2^d texels of that wish; the cap keeps sums in 32 bits
            atomicAdd(nodes[slot].below, count << min(distance, WEIGHT_BITS));
            link = fresh;
            child = slot;
            distance++;
        }
    }
}
