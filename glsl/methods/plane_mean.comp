#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/receiver.glsl"
#include "methods/sample.glsl"

// Adds up normals and offsets of the samples in the fullest bin, as whole numbers: their order does not matter.
layout(local_size_x = 64) in;
#include "methods/columns.glsl"
#define PLANE_BINDING 5
#include "methods/plane.glsl"

shared uint group_sums[4];

void main() {
    uint local = gl_LocalInvocationIndex;
    if (local < 4u) {
        group_sums[local] = 0u;
    }
    barrier();
    uvec4 sums = uvec4(0u);
    for (uint r = 0u; r < ROWS; r++) {
        uvec2 pixel;
        Sample s;
        float depth;
        if (!sample_of_row(r, pixel, s, depth) || !shone_on(pixel, s)) {
            continue;
        }
        float offset = dot(s.normal, s.from_eye);
        if (bin_of(s.normal, offset) == dominant.bin) {
            vec4 value = vec4(s.normal + 1.0, -offset / bin_offset(dominant.bin));
            sums += uvec4(round(UNIT * clamp(value, 0.0, 2.0)));
        }
    }
    for (uint i = 0u; i < 4u; i++) {
        if (sums[i] > 0u) {
            atomicAdd(group_sums[i], sums[i]);
        }
    }
    barrier();
    if (local < 4u && group_sums[local] > 0u) {
        uint before = atomicAdd(dominant.sums[2u * local], group_sums[local]);
        // the low word ran over
        if (before + group_sums[local] < before) {
            atomicAdd(dominant.sums[2u * local + 1u], 1u);
        }
    }
}
