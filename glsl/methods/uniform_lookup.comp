#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/receiver.glsl"
#include "methods/fit.glsl"

// One tap of a conventional map with receiver-plane bias; 1 where there is no surface or outside the map.
layout(local_size_x = 8, local_size_y = 8) in;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(binding = 1) uniform sampler2D depth_image;
layout(binding = 2) uniform usampler2D receiver_image;
layout(std430, binding = 3) readonly buffer FitBlock { Fit fit; };
layout(binding = 4) uniform sampler2D map;
layout(binding = 5, r32f) writeonly uniform image2D visibility_image;

float visibility(uvec2 pixel, float stored) {
    vec3 n = decode_normal(texelFetch(receiver_image, ivec2(pixel), 0).x);
    vec3 normal = vec3(dot(frame.light_x.xyz, n), dot(frame.light_y.xyz, n), dot(frame.light_z.xyz, n));
    if (normal.z >= 0.0) {
        return 0.0;
    }
    vec3 from_eye = pixel_ray(frame, pixel) * linear_depth(frame, stored);
    vec3 ls = vec3(dot(frame.light_x.xyz, from_eye), dot(frame.light_y.xyz, from_eye), 1.0);
    vec2 uv = vec2(dot(fit.row_u.xyz, ls), dot(fit.row_v.xyz, ls));
    if (any(lessThan(uv, vec2(0.0))) || any(greaterThanEqual(uv, vec2(1.0)))) {
        return 1.0;
    }
    vec2 texel = uv * vec2(textureSize(map, 0));
    // the rows are orthogonal: their directions are the map's axes in light space
    vec2 across = clamp(-normal.xy / normal.z, -200.0, 200.0);
    vec2 slope = vec2(dot(across, normalize(fit.row_u.xy)), dot(across, normalize(fit.row_v.xy))) * fit.texel.xy;
    float bias = frame.rule.y * receiver_bias(max(fit.texel.x, fit.texel.y), slope) + frame.rule.z;
    float depth = frame.light_z.w + dot(frame.light_z.xyz, from_eye) + dot(slope, floor(texel) + 0.5 - texel);
    return (depth - bias) * frame.page.z <= texelFetch(map, ivec2(texel), 0).r ? 1.0 : 0.0;
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, frame.size.xy))) {
        return;
    }
    float stored = texelFetch(depth_image, ivec2(pixel), 0).r;
    imageStore(visibility_image, ivec2(pixel), vec4(stored > 0.0 ? visibility(pixel, stored) : 1.0));
}
