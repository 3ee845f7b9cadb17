#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/receiver.glsl"
#include "shared/level.glsl"
#include "shared/key.glsl"

// The full-screen mask: visibility of every pixel; 1 where there is no surface.
layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const uint TABLE_SIZE = 1024u;
layout(constant_id = 1) const uint GUTTER = 0u;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(binding = 1) uniform sampler2D depth_image;
layout(binding = 2) uniform usampler2D receiver_image;
layout(std430, binding = 3) readonly buffer TableKeys { uint table_keys[]; };
layout(std430, binding = 4) readonly buffer Entries { uint entries[]; };
layout(binding = 5) uniform sampler2DArray atlas;
layout(binding = 6, r32f) writeonly uniform image2D visibility_image;

#include "shared/table.glsl"
#include "host/umbrage_lookup.glsl"

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, frame.size.xy))) {
        return;
    }
    float visibility = 1.0;
    float stored = texelFetch(depth_image, ivec2(pixel), 0).r;
    if (stored > 0.0) {
        uvec4 receiver = texelFetch(receiver_image, ivec2(pixel), 0);
        float depth = linear_depth(frame, stored);
        vec3 dx, dy;
        decode_derivatives(frame, receiver, depth, dx, dy);
        visibility = umbrage_visibility(pixel_ray(frame, pixel) * depth, decode_normal(receiver.x), dx, dy);
    }
    imageStore(visibility_image, ivec2(pixel), vec4(visibility));
}
