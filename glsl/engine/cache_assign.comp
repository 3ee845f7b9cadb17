#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/light.glsl"

// Gives the admitted pages their layers: their own where they have one, else the least recently used. Layers chosen this
// frame are never taken; those in this frame's quadtree go after those out of it. One workgroup.
layout(local_size_x = 256) in;
layout(constant_id = 0) const uint SLOTS = 1024u;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(std430, binding = 1) buffer CountersBlock { Counters counters; };
layout(std430, binding = 2) buffer Pages { Page pages[]; };
layout(std430, binding = 3) buffer Slots { Slot slots[]; };
layout(std430, binding = 4) buffer Order { uint order[]; };
layout(std430, binding = 5) writeonly buffer Cleared { uint cleared[]; };  // layers to clear
layout(std430, binding = 6) writeonly buffer Arguments { uint arguments[]; };
layout(std430, binding = 7) readonly buffer Lights { Light lights[]; };
layout(push_constant) uniform Push { uint argument; };  // first of 7 words: the draw that clears, a dispatch over the same layers

const uint MAX_SLOTS = 2048u;
shared uvec3 sums[256];
shared uint next[MAX_SLOTS];
shared uint clears;

// Exclusive sum over the workgroup; `total` is that of all.
uvec3 scan(uvec3 value, out uvec3 total) {
    uint local = gl_LocalInvocationIndex;
    sums[local] = value;
    barrier();
    for (uint step = 1u; step < 256u; step *= 2u) {
        uvec3 before = local >= step ? sums[local - step] : uvec3(0u);
        barrier();
        sums[local] += before;
        barrier();
    }
    total = sums[255];
    uvec3 result = sums[local] - value;
    barrier();
    return result;
}

// 0: not in this frame's quadtree, 1: in it, 2: chosen.
uint standing(uint slot) { return slots[slot].used == frame.cache.y ? 2u : slots[slot].seen == frame.cache.y ? 1u : 0u; }

// A key of zeros: moving casters.
void draw_into(uint slot, uvec2 key) {
    Slot was = slots[slot];
    if (was.key.x != 0u && was.key != key) {
        atomicAdd(counters.evicted, 1u);
    }
    Light light = lights[key_face(key) / FACES];
    float x[3] = float[3](light.axis_x.x, light.axis_x.y, light.axis_x.z);
    float z[3] = float[3](light.axis_z.x, light.axis_z.y, light.axis_z.z);
    slots[slot] = Slot(x, light.kind.z, z, key.x != 0u ? 1u : 0u, key, frame.cache.y, frame.cache.y);
    cleared[atomicAdd(clears, 1u)] = slot;
}

void main() {
    uint local = gl_LocalInvocationIndex;
    if (local == 0u) {
        clears = 0u;
    }
    // the order of eviction
    const uint share = (SLOTS + 255u) / 256u;
    uint begin = min(local * share, SLOTS);
    uint end = min(begin + share, SLOTS);
    uvec3 count = uvec3(0u);
    for (uint i = begin; i < end; i++) {
        count[standing(order[i])]++;
    }
    uvec3 total;
    uvec3 at = scan(count, total);
    at.y += total.x;
    at.z += total.x + total.y;
    for (uint i = begin; i < end; i++) {
        uint slot = order[i];
        next[at[standing(slot)]++] = slot;
    }
    uint free_count = total.x + total.y;
    barrier();

    // dynamic layers come first: they are the first to be taken again
    uint page_share = (counters.sorted + 255u) / 256u;
    uint page_begin = min(local * page_share, counters.sorted);
    uint page_end = min(page_begin + page_share, counters.sorted);
    count = uvec3(0u);
    for (uint i = page_begin; i < page_end; i++) {
        Page page = pages[i];
        if (page.admitted != 0u) {
            count += uvec3(page.draws >> 1, page.slot == NONE ? 1u : 0u, 0u);
        }
    }
    uvec3 taken;
    at = scan(count, taken);
    at.y += taken.x;
    for (uint i = page_begin; i < page_end; i++) {
        Page page = pages[i];
        if (page.admitted == 0u) {
            atomicAdd(counters.deferred, (page.draws & 1u) + (page.draws >> 1));
            continue;
        }
        // the budget of the atlas leaves enough layers; a page without one does not serve
        bool room = (page.draws < 2u || at.x < free_count) && (page.slot != NONE || at.y < free_count);
        if (!room) {
            pages[i].admitted = 2u;
            atomicAdd(counters.deferred, (page.draws & 1u) + (page.draws >> 1));
            continue;
        }
        if (page.draws > 1u) {
            pages[i].dynamic_slot = next[at.x];
            draw_into(next[at.x++], uvec2(0u));
            atomicAdd(counters.drawn_dynamic, 1u);
        }
        if ((page.draws & 1u) != 0u) {
            uint slot = page.slot == NONE ? next[at.y++] : page.slot;
            pages[i].slot = slot;
            draw_into(slot, page.key);
            atomicAdd(counters.drawn, 1u);
        }
        atomicAdd(counters.admitted, 1u);
        atomicAdd(counters.resident[key_level(page.key)], 1u);
    }
    barrier();
    // layers of the dynamic half stay in front, newly filled ones go to the end
    uint first = min(taken.x, free_count);
    uint last = min(taken.x + taken.y, free_count);
    for (uint i = local; i < SLOTS; i += 256u) {
        uint place = i < first ? i : i < last ? SLOTS - last + i : i - (last - first);
        order[place] = next[i];
    }
    if (local == 0u) {
        arguments[argument] = 3u;
        arguments[argument + 1u] = clears;
        arguments[argument + 2u] = 0u;
        arguments[argument + 3u] = 0u;
        arguments[argument + 4u] = clears;
        arguments[argument + 5u] = 1u;
        arguments[argument + 6u] = 1u;
    }
}
