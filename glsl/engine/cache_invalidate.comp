#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"

// Marks cached pages that are no longer what a fresh page would be: a cached caster that touches or touched them
// changed, or the light turned by more than their level tolerates.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint PAGE_TEXELS = 128u;
layout(constant_id = 1) const uint GUTTER = 0u;
layout(constant_id = 2) const uint SLOTS = 1024u;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(std430, binding = 1) buffer CountersBlock { Counters counters; };
layout(std430, binding = 2) readonly buffer Changed { vec4 changed[]; };
layout(std430, binding = 3) buffer Slots { Slot slots[]; };
layout(std430, binding = 4) buffer Order { uint order[]; };  // layers, least recently used first

#include "shared/caster_bounds.glsl"
#include "shared/drift.glsl"

// Frames within which all pages are exact again once the light rests.
const uint REST = 32u;

// Coarse levels bear more drift than fine ones. Pages of a level give up at different times, so that they are not all
// drawn in the same frame.
float tolerance(uint key) {
    float early = 0.5 + 0.5 * float(hash(key) & 255u) / 255.0;
    return frame.drift.y * early * power_of_two(key_level(key));
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= SLOTS) {
        return;
    }
    if ((frame.cache.x & FORGET_PAGES) != 0u) {
        slots[index].key = 0u;
        slots[index].valid = 0u;
        slots[index].seen = 0u;
        slots[index].used = 0u;
        order[index] = index;
        return;
    }
    Slot slot = slots[index];
    if (slot.key == 0u || slot.valid == 0u) {
        return;
    }
    float off = drift(slot);
    bool moves = (frame.cache.x & LIGHT_MOVED) != 0u;
    bool wrong = off > (moves ? tolerance(slot.key) : 0.0) && (moves || (hash(slot.key) + frame.cache.y) % REST == 0u);
    // what a page drawn for other axes shows may lie as far beside its bounds
    float beside = off > 0.0 ? frame.drift.y * power_of_two(key_level(slot.key)) / frame.rule.w : 0.0;
    for (uint i = 0u; i < counters.changed && !wrong; i++) {
        vec4 bounds = changed[i];
        in_page_units(bounds.xy, bounds.zw);
        bounds += vec4(-beside, -beside, beside, beside);
        wrong = !page_missed(slot.key, bounds.xy, bounds.zw);
    }
    if (wrong) {
        slots[index].valid = 0u;
        atomicAdd(counters.invalidated, 1u);
    }
}
