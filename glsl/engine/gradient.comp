#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/receiver.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(binding = 1) uniform sampler2D depth_image;
layout(binding = 2) uniform usampler2D normal_image;
layout(binding = 3, rgba32ui) writeonly uniform uimage2D receiver_image;

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, frame.size.xy))) {
        return;
    }
    float depth = texelFetch(depth_image, ivec2(pixel), 0).r;
    uvec4 receiver = uvec4(0u);
    if (depth > 0.0) {
        uint word = texelFetch(normal_image, ivec2(pixel), 0).r;
        vec3 n = decode_normal(word);
        vec3 ray = pixel_ray(frame, pixel);
        // the plane is hit at depth z = c / (n.r(x)); its derivative follows from the quotient rule, here divided by z
        float along = dot(n, ray);
        along = min(along, -1e-6 * length(ray));
        float inv = 1.0 / (along * frame.ray_dy.w);
        vec3 dx = (frame.ray_dx.xyz * along - ray * dot(n, frame.ray_dx.xyz)) * inv;
        vec3 dy = (frame.ray_dy.xyz * along - ray * dot(n, frame.ray_dy.xyz)) * inv;
        dx = clamp(dx, -65000.0, 65000.0);
        dy = clamp(dy, -65000.0, 65000.0);
        receiver = uvec4(word, packHalf2x16(dx.xy), packHalf2x16(vec2(dx.z, dy.x)), packHalf2x16(dy.yz));
    }
    imageStore(receiver_image, ivec2(pixel), receiver);
}
