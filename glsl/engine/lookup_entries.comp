#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/receiver.glsl"
#include "shared/level.glsl"
#include "shared/key.glsl"

// Debugging: which entry of the page table serves each pixel; 0 where none is needed.
layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const uint TABLE_SIZE = 1024u;
layout(constant_id = 1) const uint GUTTER = 0u;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(binding = 1) uniform sampler2D depth_image;
layout(binding = 2) uniform usampler2D receiver_image;
layout(std430, binding = 3) readonly buffer TableKeys { uint table_keys[]; };
layout(std430, binding = 4) readonly buffer Entries { uint entries[]; };
layout(binding = 5) uniform sampler2DArray atlas;
layout(binding = 6, r32ui) writeonly uniform uimage2D entry_image;

#include "shared/table.glsl"
#include "host/umbrage_lookup.glsl"

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, frame.size.xy))) {
        return;
    }
    uint entry = 0u;
    float stored = texelFetch(depth_image, ivec2(pixel), 0).r;
    uvec4 receiver = texelFetch(receiver_image, ivec2(pixel), 0);
    if (stored > 0.0 && dot(decode_normal(receiver.x), frame.light_z.xyz) < 0.0) {
        float depth = linear_depth(frame, stored);
        ivec2 page;
        vec2 inside, ls_dx, ls_dy;
        vec3 dx, dy;
        light_page(frame, pixel_ray(frame, pixel) * depth, page, inside);
        decode_derivatives(frame, receiver, depth, dx, dy);
        light_derivatives(frame, dx, dy, ls_dx, ls_dy);
        entry = on_grid(page) ? umbrage_entry(page, footprint_level(frame, ls_dx, ls_dy)) : 0u;
    }
    imageStore(entry_image, ivec2(pixel), uvec4(entry));
}
