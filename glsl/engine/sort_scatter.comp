#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/structs.glsl"

// Radix sort, step 3 of a pass: every entry goes to its place. Stable: thread t of a block owns entries 8t to 8t+7.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint BLOCK = 512u;
layout(std430, binding = 0) readonly buffer CountersBlock { Counters counters; };
layout(std430, binding = 1) readonly buffer Keys { uvec2 keys[]; };
layout(std430, binding = 2) readonly buffer Values { uint values[]; };
layout(std430, binding = 3) readonly buffer Offsets { uint offsets[]; };
layout(std430, binding = 4) writeonly buffer KeysOut { uvec2 keys_out[]; };
layout(std430, binding = 5) writeonly buffer ValuesOut { uint values_out[]; };
layout(push_constant) uniform Push { uint digit; };  // its first bit; from 32 on in the first word

#include "shared/digit.glsl"

shared uint places[16 * 64];

void main() {
    uint local = gl_LocalInvocationIndex;
    for (uint d = 0u; d < 16u; d++) {
        places[d * 64u + local] = 0u;
    }
    uint share = BLOCK / 64u;
    uint begin = min(gl_WorkGroupID.x * BLOCK + local * share, counters.sorted);
    uint end = min(begin + share, counters.sorted);
    for (uint i = begin; i < end; i++) {
        places[digit_of(keys[i]) * 64u + local]++;
    }
    barrier();
    // each of 16 threads turns the counts of one digit into places
    if (local < 16u) {
        uint sum = offsets[local * gl_NumWorkGroups.x + gl_WorkGroupID.x];
        for (uint t = 0u; t < 64u; t++) {
            uint count = places[local * 64u + t];
            places[local * 64u + t] = sum;
            sum += count;
        }
    }
    barrier();
    for (uint i = begin; i < end; i++) {
        uint at = places[digit_of(keys[i]) * 64u + local]++;
        keys_out[at] = keys[i];
        values_out[at] = values[i];
    }
}
