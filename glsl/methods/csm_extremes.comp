#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"

// The nearest and the farthest visible sample. A thread walks down 32 pixels of a column.
layout(local_size_x = 64) in;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(binding = 1) uniform sampler2D depth_image;
#define SLICES_BINDING 2
#include "methods/slices.glsl"

const uint ROWS = 32u;
shared uint group_extremes[2];

void main() {
    uint local = gl_LocalInvocationIndex;
    if (local < 2u) {
        group_extremes[local] = 0u;
    }
    barrier();
    // positive floats are ordered as their bits; 0 in either stands for none
    uvec2 own = uvec2(0u);
    for (uint r = 0u; r < ROWS; r++) {
        uvec2 pixel = uvec2(gl_GlobalInvocationID.x, gl_WorkGroupID.y * ROWS + r);
        if (any(greaterThanEqual(pixel, frame.size.xy))) {
            break;
        }
        float depth = texelFetch(depth_image, ivec2(pixel), 0).r;
        if (depth > 0.0) {
            uint bits = floatBitsToUint(depth);
            own = max(own, uvec2(bits, ~bits));
        }
    }
    if (own.x != 0u) {
        atomicMax(group_extremes[0], own.x);
        atomicMax(group_extremes[1], own.y);
    }
    barrier();
    if (local < 2u && group_extremes[local] != 0u) {
        atomicMax(extremes[local], group_extremes[local]);
    }
}
