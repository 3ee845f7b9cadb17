#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/receiver.glsl"
#include "methods/fit.glsl"
#include "methods/sample.glsl"
#include "methods/confidence.glsl"

// Blends a frame's lookup with what the same surface had in the frame before (Scherzer et al. 2007; book, 4.7).
layout(local_size_x = 8, local_size_y = 8) in;
layout(std430, binding = 5) readonly buffer Fits { Fit fits[]; };
layout(binding = 6, r32f) uniform image2D visibility_image;
// per pixel: visibility and its weight (floats), depth along the view direction, 0 where there is nothing, packed normal
layout(binding = 7, rgba32ui) readonly uniform uimage2D history_before;
layout(binding = 8, rgba32ui) writeonly uniform uimage2D history_image;
layout(std430, binding = 9) readonly buffer Moved { vec4 corners[]; };  // low and high corners of boxes relative to the scene's origin
layout(push_constant) uniform Push {
    mat4 clip_before;   // from positions relative to the eye of the frame before
    vec4 eye_moved;     // the eye less the eye of the frame before
    float exponent;
    float memory;       // most weight that history has; 0: exponential smoothing
    float rejection;    // share of the depth by which a surface may lie elsewhere
    uint moved;         // boxes
    uint side;          // of the map in texels
    uint history;       // HISTORY_*
};

const uint HISTORY_NONE = 0u;
const uint HISTORY_STILL = 1u;  // the camera did not move
const uint HISTORY_MOVED = 2u;
const float SAME_NORMAL = 0.9;  // least cosine

// Whether something moved between a sample and the light, or at the sample; `margin`: as far away as the map's texels are wide.
bool crossed_moved(vec3 from_eye, float margin) {
    vec3 p = frame.eye.xyz + from_eye;
    vec3 d = -light.faces[0].z.xyz;
    d = mix(d, vec3(1e-12), lessThan(abs(d), vec3(1e-12)));
    for (uint i = 0u; i < moved; i++) {
        vec3 a = (corners[2u * i].xyz - margin - p) / d, b = (corners[2u * i + 1u].xyz + margin - p) / d;
        vec3 low = min(a, b), high = max(a, b);
        if (max(max(low.x, low.y), max(low.z, 0.0)) <= min(min(high.x, high.y), high.z)) {
            return true;
        }
    }
    return false;
}

// Visibility and weight in the frame before; a weight of 0 where there is none. `forward`: derivatives of the depth before.
vec2 history_of(uvec2 pixel, float depth, vec3 from_eye, vec3 normal) {
    if (history == HISTORY_STILL) {
        uvec4 word = imageLoad(history_before, ivec2(pixel));
        return uintBitsToFloat(word.z) > 0.0 ? uintBitsToFloat(word.xy) : vec2(0.0);
    }
    vec4 clip = clip_before * vec4(from_eye + eye_moved.xyz, 1.0);
    if (clip.w <= 0.0) {
        return vec2(0.0);
    }
    vec2 at = (0.5 + 0.5 * clip.xy / clip.w) * vec2(frame.size.xy);
    // the receiver's plane from pixel to pixel
    vec3 dx, dy;
    decode_derivatives(frame, texelFetch(receiver_image, ivec2(pixel), 0), depth, dx, dy);
    vec3 forward = vec3(clip_before[0].w, clip_before[1].w, clip_before[2].w);
    vec2 slope = vec2(dot(forward, dx), dot(forward, dy));
    vec2 low = floor(at - 0.5);
    vec2 f = at - 0.5 - low;
    vec2 sum = vec2(0.0);
    float weights = 0.0;
    for (int i = 0; i < 4; i++) {
        vec2 step = vec2(i & 1, i >> 1);
        vec2 tap = low + step;
        if (any(lessThan(tap, vec2(0.0))) || any(greaterThanEqual(tap, vec2(frame.size.xy)))) {
            continue;
        }
        uvec4 word = imageLoad(history_before, ivec2(tap));
        float before = uintBitsToFloat(word.z);
        float expected = clip.w + dot(slope, tap + 0.5 - at);
        if (before <= 0.0 || abs(before - expected) > rejection * clip.w || dot(decode_normal(word.w), normal) < SAME_NORMAL) {
            continue;
        }
        vec2 share = mix(1.0 - f, f, step);
        float weight = share.x * share.y;
        sum += weight * uintBitsToFloat(word.xy);
        weights += weight;
    }
    return weights > 1e-3 ? sum / weights : vec2(0.0);
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, frame.size.xy))) {
        return;
    }
    float depth = texelFetch(depth_image, ivec2(pixel), 0).r;
    Sample s = sample_at(pixel, depth);
    if (depth <= 0.0 || !shone_on(pixel, s)) {
        imageStore(history_image, ivec2(pixel), uvec4(0u));
        return;
    }
    Fit fit = fits[0];
    vec3 t = vec3(light_space(0u, s.from_eye).xy, 1.0);
    vec2 uv = vec2(dot(fit.row_u.xyz, t), dot(fit.row_v.xyz, t)) / dot(fit.row_w.xyz, t);
    float fresh = imageLoad(visibility_image, ivec2(pixel)).r;
    float weight = pow(confidence(uv * float(side)), exponent);
    vec2 before = vec2(0.0);
    if (history != HISTORY_NONE && !crossed_moved(s.from_eye, 2.0 * max(fit.texel.x, fit.texel.y))) {
        before = history_of(pixel, depth, s.from_eye, s.normal);
    }
    float kept = memory > 0.0 ? min(before.y, memory) : before.y > 0.0 ? 1.0 - weight : 0.0;
    float total = max(kept + weight, 1e-20);
    float visibility = before.x + (fresh - before.x) * (kept > 0.0 ? weight / total : 1.0);
    imageStore(history_image, ivec2(pixel), uvec4(floatBitsToUint(vec2(visibility, total)), floatBitsToUint(depth), texelFetch(receiver_image, ivec2(pixel), 0).x));
    imageStore(visibility_image, ivec2(pixel), vec4(visibility));
}
