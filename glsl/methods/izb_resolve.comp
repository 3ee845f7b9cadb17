#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"

// The share of each pixel's samples that the light reaches, less what translucent casters hold back; 1 where there is no surface.
layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const uint SAMPLES = 1u;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(std430, binding = 1) readonly buffer Shadowed { uint shadowed[]; };
layout(binding = 2, r32f) writeonly uniform image2D visibility_image;
layout(constant_id = 1) const bool TRANSLUCENT = false;
#define HELD_BACK_BINDING 3
#include "methods/izb_held_back.glsl"

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (all(lessThan(pixel, frame.size.xy))) {
        uint index = pixel.y * frame.size.x + pixel.x;
        uint dark = shadowed[index];
        float lit = float(SAMPLES - uint(bitCount(dark)));
        if (TRANSLUCENT) {
            lit = 0.0;
            for (uint i = 0u; i < SAMPLES; i++) {
                lit += (dark >> i & 1u) == 0u ? transmittance(index * SAMPLES + i) : 0.0;
            }
        }
        imageStore(visibility_image, ivec2(pixel), vec4(lit / float(SAMPLES)));
    }
}
