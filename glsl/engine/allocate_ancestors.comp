#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/light.glsl"

// Grows the quadtrees above the requested pages: every ancestor up to the root level gets a node, its pixel weight and
// the links to its children. The roots of directional lights always exist; a face that nobody asks for has none.
layout(local_size_x = 256) in;
layout(constant_id = 0) const uint TABLE_SIZE = 1024u;
layout(constant_id = 1) const uint NODE_CAPACITY = 1024u;
layout(constant_id = 2) const int WEIGHT_BITS = 10;
layout(std430, binding = 0) buffer CountersBlock { Counters counters; };
layout(std430, binding = 1) buffer TableKeys { uint table_keys[]; };
layout(std430, binding = 2) buffer Nodes { Node nodes[]; };
layout(std430, binding = 3) buffer NodeList { uint node_list[]; };
layout(std140, binding = 4) uniform FrameBlock { Frame frame; };
layout(std430, binding = 5) readonly buffer Lights { Light lights[]; };
layout(std430, binding = 6) writeonly buffer Roots { uint roots[]; };  // of each face: table slot + 1

#include "shared/table.glsl"
#include "shared/table_insert.glsl"

uint node_insert(uvec2 key, out bool fresh) {
    uint slot = table_insert(key, fresh);
    if (slot == NONE) {
        atomicAdd(counters.failed, 1u);
    } else if (fresh) {
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
    uint id = gl_GlobalInvocationID.x;
    uint stride = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
    bool fresh;
    for (uint i = id; i < frame.lights.x; i += stride) {
        if (lights[i].kind.x == LIGHT_DIRECTIONAL) {
            roots[i * FACES] = node_insert(key_of(ROOT_LEVEL, i * FACES, uvec2(0u)), fresh) + 1u;
        }
    }
    for (uint i = id; i < counters.leaves; i += stride) {
        uint child = node_list[i];
        uvec2 key = table_key(child);
        uint count = nodes[child].own;
        bool link = true;
        int distance = 1;
        while (key_level(key) < ROOT_LEVEL) {
            uint quadrant = key_quadrant(key);
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
        if (link && key_level(key) == ROOT_LEVEL) {
            roots[key_face(key)] = child + 1u;
        }
    }
}
