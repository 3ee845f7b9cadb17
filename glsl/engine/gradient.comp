#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/receiver.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(binding = 1) uniform sampler2D depth_image;
layout(binding = 4) uniform usampler2D normal_image;

#include "shared/receiver_plane.glsl"

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, frame.size.xy))) {
        return;
    }
    float stored = texelFetch(depth_image, ivec2(pixel), 0).r;
    if (is_surface(frame, stored)) {
        store_plane(pixel, linear_depth(frame, stored), texelFetch(normal_image, ivec2(pixel), 0).r);
    } else {
        store_nothing(pixel);
    }
}
