#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/light.glsl"

// Marks cached pages that are no longer what a fresh page would be: a cached caster that touches or touched them
// changed, or the light turned by more than their level tolerates.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint PAGE_TEXELS = 128u;
layout(constant_id = 1) const uint GUTTER = 0u;
layout(constant_id = 2) const uint SLOTS = 1024u;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(std430, binding = 1) buffer CountersBlock { Counters counters; };
layout(std430, binding = 2) readonly buffer Changed { vec4 changed[]; };  // centres and half sizes of boxes along the world's axes
layout(std430, binding = 3) buffer Slots { Slot slots[]; };
layout(std430, binding = 4) buffer Order { uint order[]; };  // layers, least recently used first
layout(std430, binding = 5) readonly buffer Lights { Light lights[]; };

#include "shared/caster_bounds.glsl"
#include "shared/drift.glsl"

// Frames within which all pages are exact again once the light rests.
const uint REST = 32u;

// Units * texels by which a page's content may be off: coarse levels bear more drift than fine ones. Pages of a level
// give up at different times, so that they are not all drawn in the same frame.
float tolerance(uvec2 key) {
    float early = 0.5 + 0.5 * float(key_hash(key) & 255u) / 255.0;
    return frame.rule.z * early * power_of_two(key_level(key));
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= SLOTS) {
        return;
    }
    if ((frame.cache.x & FORGET_PAGES) != 0u) {
        slots[index].key = uvec2(0u);
        slots[index].valid = 0u;
        slots[index].seen = 0u;
        slots[index].used = 0u;
        order[index] = index;
        return;
    }
    Slot slot = slots[index];
    if (slot.key.x == 0u || slot.valid == 0u) {
        return;
    }
    uint face = key_face(slot.key);
    Light light = lights[face / FACES];
    float off = drift(light, slot);
    bool moves = light.kind.y != 0u;
    bool wrong = light.kind.x == LIGHT_NONE || light.kind.z != slot.revision;
    wrong = wrong || (off > (moves ? tolerance(slot.key) : 0.0) && (moves || (key_hash(slot.key) + frame.cache.y) % REST == 0u));
    // what a page drawn for other axes shows may lie as far beside its bounds
    float beside = off > 0.0 ? frame.rule.z * power_of_two(key_level(slot.key)) / frame.rule.x : 0.0;
    for (uint i = 0u; i < counters.changed && !wrong; i++) {
        vec3 reach = changed[2u * i + 1u].xyz;
        Box box = Box(changed[2u * i].xyz, vec3[3](vec3(reach.x, 0.0, 0.0), vec3(0.0, reach.y, 0.0), vec3(0.0, 0.0, reach.z)));
        vec2 low, high;
        wrong = face_bounds(light, face % FACES, box, low, high) && !page_missed(slot.key, low - beside, high + beside);
    }
    if (wrong) {
        slots[index].valid = 0u;
        atomicAdd(counters.invalidated, 1u);
    }
}
