#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"

// Describes the chosen pages, now in the order of their keys: place in light space, layer from earlier frames, and which
// layers must be drawn. Marks the way down to these in the quadtree.
layout(local_size_x = 256) in;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(std430, binding = 1) buffer CountersBlock { Counters counters; };
layout(std430, binding = 2) buffer Nodes { Node nodes[]; };
layout(std430, binding = 3) readonly buffer Keys { uint keys[]; };
layout(std430, binding = 4) readonly buffer Values { uint values[]; };
layout(std430, binding = 5) writeonly buffer Pages { Page pages[]; };
layout(std430, binding = 6) writeonly buffer PairCounts { uint pair_counts[]; };  // 4 a page
layout(std430, binding = 7) buffer Slots { Slot slots[]; };

void mark_way(uint node, uint bits) {
    for (int step = 0; step <= ROOT_LEVEL; step++) {
        uint parent = nodes[node].parent;
        if ((atomicOr(nodes[node].marks, bits) & bits) == bits || parent == 0u) {
            break;
        }
        node = parent - 1u;
    }
}

void main() {
    for (uint i = gl_GlobalInvocationID.x; i < counters.sorted; i += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
        uint key = keys[i];
        uint node = values[i];
        int level = key_level(key);
        // exact: an integer below 2^24 times a power of two
        ivec2 corner = frame.anchor_page.xy + (ivec2(key_page(key)) << level);
        vec2 origin = vec2(corner) * frame.page.x;
        float scale = frame.rule.w * frame.page.y * power_of_two(-level);
        uint held = nodes[node].slot;
        bool hit = held != 0u && (held & STALE) == 0u;
        uint slot = held != 0u ? (held & ~(STALE | TURNED)) - 1u : NONE;
        uint turned = hit && (held & TURNED) != 0u ? 1u : 0u;
        uint draws = (hit ? 0u : 1u) | ((nodes[node].marks & MARK_DYNAMIC) != 0u ? 2u : 0u);
        pages[i] = Page(key, node, slot, NONE, draws, 0u, origin, scale, turned);
        nodes[node].page = i + 1u;
        for (uint k = 0u; k < 4u; k++) {
            pair_counts[4u * i + k] = 0u;
        }
        if (slot != NONE) {
            slots[slot].used = frame.cache.y;
            if (hit) {
                atomicAdd(counters.hits, 1u);
            } else {
                atomicAdd(counters.stale, 1u);
            }
        }
        if (draws != 0u) {
            mark_way(node, draws * MARK_DRAWN);
        }
    }
}
