#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/light.glsl"

// Puts the chosen pages in the order of their keys and describes them: place in the face, layer from earlier frames, and
// which layers must be drawn. Marks the way down to these in the quadtree.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint PAGE_CAPACITY = 1024u;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(std430, binding = 1) buffer CountersBlock { Counters counters; };
layout(std430, binding = 2) buffer Nodes { Node nodes[]; };
layout(std430, binding = 3) readonly buffer Keys { uvec2 keys[]; };
layout(std430, binding = 4) readonly buffer Values { uint values[]; };
layout(std430, binding = 5) writeonly buffer Pages { Page pages[]; };
layout(std430, binding = 6) writeonly buffer PairCounts { uint pair_counts[]; };  // PAIR_KINDS of each layer of each page
layout(std430, binding = 7) buffer Slots { Slot slots[]; };
layout(std430, binding = 8) readonly buffer Lights { Light lights[]; };

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
    uint count = min(counters.pages, PAGE_CAPACITY);
    if (gl_GlobalInvocationID.x == 0u) {
        counters.sorted = count;
    }
    for (uint i = gl_GlobalInvocationID.x; i < count; i += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
        uvec2 key = keys[i];
        uint node = values[i];
        // a few hundred pages: each counts those before it
        uint place = 0u;
        for (uint j = 0u; j < count; j++) {
            uvec2 other = keys[j];
            place += other.x < key.x || (other.x == key.x && other.y < key.y) ? 1u : 0u;
        }
        int level = key_level(key);
        Light light = lights[key_face(key) / FACES];
        ivec2 corner = (ivec2(key_page(key)) << level) - HALF;
        // exact: an integer below 2^24 times a power of two
        vec2 origin = vec2(corner) * light.scale.y;
        float scale = frame.rule.x * light.scale.x * power_of_two(-level);
        uint held = nodes[node].slot;
        bool hit = held != 0u && (held & STALE) == 0u;
        uint slot = held != 0u ? (held & ~(STALE | TURNED)) - 1u : NONE;
        uint turned = hit && (held & TURNED) != 0u ? 1u : 0u;
        uint draws = (hit ? 0u : 1u) | ((nodes[node].marks & MARK_DYNAMIC) != 0u ? 2u : 0u);
        pages[place] = Page(key, node, slot, NONE, draws, 0u, turned, scale, 0u, origin);
        nodes[node].page = place + 1u;
        for (uint k = 0u; k < 2u * PAIR_KINDS; k++) {
            pair_counts[2u * PAIR_KINDS * place + k] = 0u;
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
