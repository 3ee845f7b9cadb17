#version 460
#extension GL_GOOGLE_include_directive : require

// Puts what rays found into the mask, where the lookup left zeros.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint MASK_BITS = 32u;
layout(std430, binding = 0) readonly buffer Count { uint count; };
layout(std430, binding = 1) readonly buffer Items { uvec2 items[]; };
layout(std430, binding = 2) readonly buffer Visibility { uint visibility[]; };
layout(binding = 3, r32ui) uniform uimage2DArray mask_image;
layout(push_constant) uniform Push { uint capacity; };

void main() {
    uint index = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationIndex;
    if (index >= min(count, capacity) || visibility[index] == 0u) {
        return;
    }
    uvec2 item = items[index];
    uint bit = item.y * MASK_BITS;
    uint lit = MASK_BITS == 32u ? floatBitsToUint(1.0) : (1u << MASK_BITS) - 1u;
    imageAtomicOr(mask_image, ivec3(item.x & 0xffffu, item.x >> 16, bit / 32u), lit << (bit % 32u));
}
