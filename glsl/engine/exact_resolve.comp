#version 460
#extension GL_GOOGLE_include_directive : require

// Puts what rays found into the mask, where the lookup left zeros: a thread for each ray, of which the first of a pixel works.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint MASK_BITS = 32u;
layout(constant_id = 1) const uint SAMPLES = 1u;
layout(std430, binding = 0) readonly buffer Count { uint count; };
layout(std430, binding = 1) readonly buffer Items { uvec2 items[]; };  // x: pixel, 16 bits each; y: slot of the light (16 bits), samples that are lit (8 bits), rays from this one on (8 bits)
layout(std430, binding = 2) readonly buffer Visibility { uint visibility[]; };
layout(binding = 3, r32ui) uniform uimage2DArray mask_image;
layout(push_constant) uniform Push { uint capacity; };

#include "shared/mask.glsl"

void main() {
    uint index = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationIndex;
    if (index >= min(count, capacity)) {
        return;
    }
    uvec2 item = items[index];
    uint rays = item.y >> 24;
    uint lit = item.y >> 16 & 0xffu;
    for (uint i = 0u; i < rays; i++) {
        lit += visibility[index + i];
    }
    if (rays == 0u || lit == 0u) {
        return;
    }
    uint bit = (item.y & 0xffffu) * MASK_BITS;
    uint word = encode_visibility(float(lit) / float(SAMPLES)) << (bit % 32u);
    imageAtomicOr(mask_image, ivec3(item.x & 0xffffu, item.x >> 16, bit / 32u), word);
}
