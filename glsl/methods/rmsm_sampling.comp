#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/light.glsl"
#include "shared/receiver.glsl"
#include "shared/sampling.glsl"

// Debugging: the sampling error of each pixel in the page that serves it towards one light.
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
layout(std430, binding = 6) readonly buffer Lights { Light lights[]; };
layout(std430, binding = 7) writeonly buffer Errors { SamplingError errors[]; };
layout(push_constant) uniform Push { uint slot; };  // of the light

#include "shared/light_receiver.glsl"
#include "shared/table.glsl"
#include "host/umbrage_lookup.glsl"

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, frame.size.xy))) {
        return;
    }
    SamplingError error = SamplingError(0.0, 0.0, 0.0, 0.0, NO_PART);
    float depth = texelFetch(depth_image, ivec2(pixel), 0).r;
    if (depth > 0.0) {
        uvec4 packed_receiver = texelFetch(receiver_image, ivec2(pixel), 0);
        Light light = lights[frame.size.w + slot];
        vec3 ray = pixel_ray(frame, pixel);
        vec3 normal = decode_normal(packed_receiver.x);
        // the level is chosen by the derivatives as they are stored
        vec3 dx, dy;
        decode_derivatives(frame, packed_receiver, depth, dx, dy);
        Receiver r;
        bool reached = light_receiver(frame, light, ray * depth, normal, dx, dy, r);
        uint entry = reached && on_face(r.page) ? umbrage_entry(key_of(r.level, r.face, uvec2(r.page) >> r.level)) : 0u;
        if (entry != 0u) {
            bool parallel = light.kind.x == LIGHT_DIRECTIONAL;
            vec3 to_light = parallel ? -light.axis_z.xyz : -normalize(ray * depth + light.eye.xyz);
            vec3 even = even_normal(ray, to_light);
            // texels of the page per side of a level-0 page
            float texels = frame.rule.x * exp2(-float(entry_level(entry)));
            vec2 sides[2];
            for (uint i = 0u; i < 2u; i++) {
                mat2x3 steps = plane_steps(frame, ray, depth, i == 0u ? normal : even);
                Receiver place;
                light_receiver(frame, light, ray * depth, normal, steps[0], steps[1], place);
                sides[i] = texel_sides(place.dx * texels, place.dy * texels);
            }
            error = SamplingError(sides[0].x, sides[0].y, sides[1].x, sides[1].y, entry_slot(entry));
        }
    }
    errors[pixel.y * frame.size.x + pixel.x] = error;
}
