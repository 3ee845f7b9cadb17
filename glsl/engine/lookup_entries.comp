#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/light.glsl"
#include "shared/receiver.glsl"

// Debugging: which entry of the page table serves each pixel towards the first light; 0 where none is needed.
layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const uint TABLE_SIZE = 1024u;
layout(constant_id = 1) const uint GUTTER = 0u;
const bool SUN = false;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(binding = 1) uniform sampler2D depth_image;
layout(binding = 2) uniform usampler2D receiver_image;
layout(std430, binding = 3) readonly buffer TableKeys { uint table_keys[]; };
layout(std430, binding = 4) readonly buffer Entries { uint entries[]; };
layout(binding = 5) uniform sampler2DArray atlas;
layout(binding = 6, r32ui) writeonly uniform uimage2D entry_image;
layout(std430, binding = 7) readonly buffer Lights { Light lights[]; };

#include "shared/light_receiver.glsl"
#include "shared/table.glsl"
#include "host/umbrage_lookup.glsl"

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, frame.size.xy))) {
        return;
    }
    uint entry = 0u;
    float depth = texelFetch(depth_image, ivec2(pixel), 0).r;
    if (depth > 0.0) {
        uvec4 receiver = texelFetch(receiver_image, ivec2(pixel), 0);
        vec3 dx, dy;
        decode_derivatives(frame, receiver, depth, dx, dy);
        Receiver r;
        bool reached = light_receiver(frame, lights[frame.size.w], pixel_ray(frame, pixel) * depth, decode_normal(receiver.x), dx, dy, r);
        entry = reached && on_face(r.page) ? umbrage_entry(key_of(r.level, r.face, uvec2(r.page) >> r.level)) : 0u;
    }
    imageStore(entry_image, ivec2(pixel), uvec4(entry));
}
