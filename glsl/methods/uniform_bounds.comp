#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/receiver.glsl"

// Bounds of the visible samples that face the light, across the light, for 16 rotations of the map.
// A thread walks down 32 pixels of a column.
layout(local_size_x = 64) in;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(binding = 1) uniform sampler2D depth_image;
layout(binding = 2) uniform usampler2D receiver_image;
layout(std430, binding = 3) buffer Bounds { uint bounds[64]; };  // per rotation: low u, low v, high u, high v; ordered bits

const uint ANGLES = 16u;
const uint ROWS = 32u;
shared uint group_bounds[64];

// Unsigned integers in the order of the floats; 0 is never produced.
uint ordered(float v) {
    uint bits = floatBitsToUint(v);
    return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}

void main() {
    uint local = gl_LocalInvocationIndex;
    group_bounds[local] = 0u;
    barrier();
    // "low" is kept as the maximum of the negated coordinate
    vec2 high[ANGLES];
    vec2 low[ANGLES];
    for (uint a = 0u; a < ANGLES; a++) {
        high[a] = vec2(-1e30);
        low[a] = vec2(-1e30);
    }
    uint x = gl_GlobalInvocationID.x;
    bool any_sample = false;
    for (uint r = 0u; r < ROWS; r++) {
        uvec2 pixel = uvec2(x, gl_WorkGroupID.y * ROWS + r);
        if (any(greaterThanEqual(pixel, frame.size.xy))) {
            break;
        }
        float stored = texelFetch(depth_image, ivec2(pixel), 0).r;
        if (stored <= 0.0 || dot(decode_normal(texelFetch(receiver_image, ivec2(pixel), 0).x), frame.light_z.xyz) >= 0.0) {
            continue;
        }
        any_sample = true;
        vec3 from_eye = pixel_ray(frame, pixel) * linear_depth(frame, stored);
        vec2 ls = vec2(dot(frame.light_x.xyz, from_eye), dot(frame.light_y.xyz, from_eye));
        for (uint a = 0u; a < ANGLES; a++) {
            float angle = float(a) * (1.57079632679 / float(ANGLES));
            vec2 uv = vec2(cos(angle) * ls.x + sin(angle) * ls.y, cos(angle) * ls.y - sin(angle) * ls.x);
            high[a] = max(high[a], uv);
            low[a] = max(low[a], -uv);
        }
    }
    if (any_sample) {
        for (uint a = 0u; a < ANGLES; a++) {
            atomicMax(group_bounds[4u * a], ordered(low[a].x));
            atomicMax(group_bounds[4u * a + 1u], ordered(low[a].y));
            atomicMax(group_bounds[4u * a + 2u], ordered(high[a].x));
            atomicMax(group_bounds[4u * a + 3u], ordered(high[a].y));
        }
    }
    barrier();
    if (group_bounds[local] != 0u) {
        atomicMax(bounds[local], group_bounds[local]);
    }
}
