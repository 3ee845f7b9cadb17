#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "methods/forward.glsl"

// The share of the kernel around a pixel's place in the map whose texels see the pixel's surface. What no splat reaches is in
// shadow if the nearest texel sees something before it; otherwise it is a hole.
layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 3) const uint FILL = 0u;  // 1: holes are lit
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(binding = 1) uniform sampler2DArray map;
layout(std430, binding = 2) buffer Splats {
    ForwardCounts counts;
    uint blocks[];
};
layout(std430, binding = 3) readonly buffer Samples { ForwardSample samples[]; };
layout(std430, binding = 4) buffer Sums { uint sums[]; };
layout(binding = 5, r32f) writeonly uniform image2D visibility_image;

// Weights of all texels along an axis.
uint total(int at, int side) {
    uint sum = 0u;
    // the first may be out of reach: it weighs nothing
    int first = (at - int(REACH) - 128) >> 8;
    for (int i = max(first, 0); i <= min(first + int(REACH / 128u) + 2, side - 1); i++) {
        sum += weight(at - 256 * i - 128);
    }
    return sum;
}

float visibility(uint i) {
    ForwardSample s = samples[i];
    if (s.layer == UNLIT) {
        return 0.0;
    }
    if (s.layer == NO_SURFACE || s.layer == OUTSIDE) {
        return 1.0;
    }
    ivec2 texel = place(s) >> 8;
    float on_plane = texelFetch(map, ivec3(texel, s.layer), 0).r - depth_change(s, texel);
    if (sums[i] == 0u && on_plane <= s.nearest) {
        sums[i] = HOLE;
        atomicAdd(counts.holes, 1u);
        return float(FILL);
    }
    int side = textureSize(map, 0).x;
    uint all = total(s.at_x, side) * total(s.at_y, side);
    return float(min(sums[i], all)) / float(all);
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (all(lessThan(pixel, frame.size.xy))) {
        imageStore(visibility_image, ivec2(pixel), vec4(visibility(pixel.y * frame.size.x + pixel.x)));
    }
}
