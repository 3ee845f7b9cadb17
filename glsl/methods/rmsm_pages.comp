#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/light.glsl"
#include "shared/receiver.glsl"
#include "shared/page_word.glsl"

// Debugging: the page that serves each pixel towards the first light, as a page word; 0 where none is needed.
layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const uint TABLE_SIZE = 1024u;
layout(constant_id = 1) const uint GUTTER = 0u;
layout(constant_id = 2) const int TOLERANCE = 0;  // levels by which a page may be coarser than the finest asked for
const bool SUN = false;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(binding = 1) uniform sampler2D depth_image;
layout(binding = 2) uniform usampler2D receiver_image;
layout(std430, binding = 3) readonly buffer TableKeys { uint table_keys[]; };
layout(std430, binding = 4) readonly buffer Entries { uint entries[]; };
layout(binding = 5) uniform sampler2DArray atlas;
layout(std430, binding = 6) readonly buffer Lights { Light lights[]; };
layout(std430, binding = 7) readonly buffer States { uint states[]; };
layout(std430, binding = 8) writeonly buffer Pages { uint pages[]; };

#include "shared/light_receiver.glsl"
#include "shared/table.glsl"
#include "host/umbrage_lookup.glsl"

// The page of a receiver is as new as the newer of its two layers.
uint state_of(uint entry) {
    uint moving = entry_dynamic(entry);
    uint still = states[entry_slot(entry)];
    return moving == 0u ? still : max(still, states[moving - 1u]);
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, frame.size.xy))) {
        return;
    }
    uint word = 0u;
    float depth = texelFetch(depth_image, ivec2(pixel), 0).r;
    if (depth > 0.0) {
        uvec4 receiver = texelFetch(receiver_image, ivec2(pixel), 0);
        vec3 dx, dy;
        decode_derivatives(frame, receiver, depth, dx, dy);
        Receiver r;
        bool reached = light_receiver(frame, lights[frame.size.w], pixel_ray(frame, pixel) * depth, decode_normal(receiver.x), dx, dy, r);
        uint entry = reached && on_face(r.page) ? umbrage_entry(key_of(r.level, r.face, uvec2(r.page) >> r.level)) : 0u;
        if (entry != 0u) {
            bool coarser = entry_level(entry) > r.level + TOLERANCE;
            word = make_page_word(entry_slot(entry), entry_level(entry), coarser, state_of(entry));
        }
    }
    pages[pixel.y * frame.size.x + pixel.x] = word;
}
