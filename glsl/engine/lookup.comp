#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/light.glsl"
#include "shared/receiver.glsl"

// The full-screen mask: visibility of every pixel towards every light; 1 where there is no surface.
layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const uint TABLE_SIZE = 1024u;
layout(constant_id = 1) const uint GUTTER = 0u;
layout(constant_id = 2) const uint MASK_BITS = 32u;  // of a light: 1, 8 (fraction of 255) or 32 (a float)
layout(constant_id = 3) const bool SUN = false;
layout(constant_id = 4) const uint FILTER = 0u;
layout(constant_id = 5) const uint TAPS = 4u;
layout(constant_id = 6) const bool LEVEL_BLEND = false;
layout(constant_id = 7) const bool RANGED = false;  // whether `ranges` are known
layout(constant_id = 8) const bool EXACT = false;     // whether what the map cannot decide is left to rays
layout(constant_id = 9) const uint RAY_CAPACITY = 0u;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(binding = 1) uniform sampler2D depth_image;
layout(binding = 2) uniform usampler2D receiver_image;
layout(std430, binding = 3) readonly buffer TableKeys { uint table_keys[]; };
layout(std430, binding = 4) readonly buffer Entries { uint entries[]; };
layout(binding = 5) uniform sampler2DArray atlas;
layout(binding = 6, r32ui) writeonly uniform uimage2DArray mask_image;
layout(std430, binding = 7) readonly buffer Lights { Light lights[]; };
layout(std430, binding = 8) readonly buffer TileLights { uint tile_lights[]; };
layout(std430, binding = 9) readonly buffer Ranges { vec2 ranges[]; };
layout(std430, binding = 10) buffer RayCount { uint ray_count; };
layout(std430, binding = 11) writeonly buffer RayItems { uvec2 ray_items[]; };  // x: pixel, 16 bits each; y: slot of the light
layout(std430, binding = 12) writeonly buffer Rays { vec4 rays[]; };  // two each: receiver relative to the eye and t_max, direction and packed normal

#include "shared/light_receiver.glsl"
#include "shared/table.glsl"
#include "host/umbrage_lookup.glsl"
#include "host/umbrage_filter.glsl"
#include "shared/decide.glsl"

// Visibility, or 0 and a ray where the map cannot decide.
float visibility_of(uint slot, Light light, vec3 from_eye, vec3 n, vec3 dx, vec3 dy) {
    if (FILTER != FILTER_HARD) {
        return umbrage_filtered(slot, light, from_eye, n, dx, dy, gl_GlobalInvocationID.xy);
    }
    if (!EXACT) {
        return umbrage_visibility(slot, light, from_eye, n, dx, dy);
    }
    Receiver r;
    if (!light_receiver(frame, light, from_eye, n, dx, dy, r)) {
        return 0.0;
    }
    if (!on_face(r.page)) {
        return 1.0;
    }
    uint entry = umbrage_entry(key_of(r.level, slot * FACES + r.face, uvec2(r.page) >> r.level));
    int decision = MAP_UNDECIDED;
    if (entry != 0u) {
        float footprint = length(from_eye) * frame.ray_dy.w;
        float texel = r.unit * power_of_two(entry_level(entry)) / frame.rule.x;
        if (texel <= MOST_PIXELS * footprint) {
            decision = map_decides(umbrage_plane(light, r, entry), umbrage_layers(entry), SELF * light.rule.y <= footprint);
        }
    }
    if (decision != MAP_UNDECIDED) {
        return float(decision);
    }
    uint index = atomicAdd(ray_count, 1u);
    if (index >= RAY_CAPACITY) {
        return umbrage_visibility(slot, light, from_eye, n, dx, dy);
    }
    bool sun = SUN || light.kind.x == LIGHT_DIRECTIONAL;
    ray_items[index] = uvec2(gl_GlobalInvocationID.x | gl_GlobalInvocationID.y << 16, slot);
    rays[2u * index] = vec4(from_eye, sun ? 1e30 : 1.0);
    rays[2u * index + 1u] = vec4(sun ? -light.axis_z.xyz : -(from_eye + light.eye.xyz), uintBitsToFloat(encode_normal(n)));
    return 0.0;
}

uint encode(float visibility) {
    return MASK_BITS == 32u ? floatBitsToUint(visibility) : uint(visibility * float((1u << MASK_BITS) - 1u) + 0.5);
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, frame.size.xy))) {
        return;
    }
    float stored = texelFetch(depth_image, ivec2(pixel), 0).r;
    uvec4 receiver = texelFetch(receiver_image, ivec2(pixel), 0);
    float depth = linear_depth(frame, stored);
    vec3 from_eye = pixel_ray(frame, pixel) * depth;
    vec3 n = decode_normal(receiver.x);
    vec3 dx, dy;
    decode_derivatives(frame, receiver, depth, dx, dy);
    if (SUN) {
        // the words of the layers beyond the first light's are not read
        float visibility = stored > 0.0 ? visibility_of(0u, frame.sun, from_eye, n, dx, dy) : 1.0;
        imageStore(mask_image, ivec3(pixel, 0), uvec4(encode(visibility)));
        return;
    }
    uint words = (frame.lights.x + 31u) / 32u;
    uint tile = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * words;
    const uint in_layer = 32u / MASK_BITS;
    int layers = imageSize(mask_image).z;
    for (int layer = 0; layer < layers; layer++) {
        uint first = uint(layer) * in_layer;
        // bits of the lights of this layer
        uint bits = first < frame.lights.x ? tile_lights[tile + first / 32u] >> (first % 32u) : 0u;
        bits &= in_layer == 32u ? 0xffffffffu : (1u << in_layer) - 1u;
        uint word = 0u;
        if (stored <= 0.0) {
            word = MASK_BITS == 32u ? encode(1.0) : 0xffffffffu;
        } else {
            for (; bits != 0u; bits &= bits - 1u) {
                uint light = uint(findLSB(bits));
                word |= encode(visibility_of(first + light, lights[frame.size.w + first + light], from_eye, n, dx, dy)) << (light * MASK_BITS % 32u);
            }
        }
        imageStore(mask_image, ivec3(pixel, layer), uvec4(word));
    }
}
