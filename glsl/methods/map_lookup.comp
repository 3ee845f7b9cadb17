#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/key.glsl"
#include "shared/receiver.glsl"
#include "methods/fit.glsl"
#include "methods/sample.glsl"

// A lookup with receiver-plane bias: the nearest texel, or a kernel around it; 1 where there is no surface or no layer holds the sample.
layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 2) const uint FILTER = 0u;
layout(constant_id = 3) const uint TAPS = 4u;
layout(std430, binding = 5) readonly buffer Fits { Fit fits[]; };
layout(binding = 6) uniform sampler2DArray map;
layout(binding = 7, r32f) writeonly uniform image2D visibility_image;

uint layer_count(uvec2 layers) { return 1u; }
uint layer_of(uvec2 layers, uint i) { return layers.x; }
vec4 layer_quad(uint layer, vec2 low) {
    // the gather of a nearest sampler: its four texels meet at the coordinate given
    return textureGather(map, vec3((low + 1.0) / vec2(textureSize(map, 0).xy), float(layer)), 0).wzxy;
}
float layer_depth(uint layer, vec2 texel) { return texelFetch(map, ivec3(texel, layer), 0).r; }

#include "shared/kernel.glsl"

// False where the layer does not hold the sample.
bool look_up(uint layer, uvec2 pixel, Sample s, out float lit) {
    uint face = face_of(layer);
    vec3 ls = light_space(face, s.from_eye);
    float w = divisor(ls.z);
    vec3 t = vec3(ls.xy / w, 1.0);
    Fit fit = fits[layer];
    vec2 uv = vec2(dot(fit.row_u.xyz, t), dot(fit.row_v.xyz, t));
    if (w <= 0.0 || any(lessThan(uv, vec2(0.0))) || any(greaterThanEqual(uv, vec2(1.0)))) {
        return false;
    }
    vec3 normal = turned(face, s.normal);
    vec2 texel = uv * vec2(textureSize(map, 0).xy);
    vec2 size = fit.texel.xy * w;
    // change of z per unit across, in the receiver's plane at constant x / w and y / w; the rows are orthogonal: their
    // directions are the map's axes in light space
    float facing = has_position() ? dot(normal, ls) : normal.z;
    vec2 across = clamp(-normal.xy * w / facing, -200.0, 200.0);
    vec2 slope = vec2(dot(across, normalize(fit.row_u.xy)), dot(across, normalize(fit.row_v.xy))) * size;
    float bias = light.rule.x * receiver_bias(max(size.x, size.y), slope) + light.rule.y;
    if (FILTER != FILTER_HARD) {
        // stored depth is affine over the receiver's plane
        float nearer = has_position() ? max(ls.z - bias, 1e-6 * ls.z) : ls.z - bias;
        float per_z = has_position() ? -light.depth.y / (ls.z * ls.z) : light.depth.x;
        lit = kernel_visibility(Plane(texel, stored_depth(nearer), slope * per_z, 0.0), uvec2(layer, 0u), pixel);
        return true;
    }
    float change = dot(slope, floor(texel) + 0.5 - texel);
    // what is affine over a plane is z, or 1 / z for a light with a position
    float z = has_position() ? ls.z * ls.z / max(ls.z - change, 1e-3 * ls.z) : ls.z + change;
    float nearer = has_position() ? max(z - bias, 1e-6 * ls.z) : z - bias;
    lit = stored_depth(nearer) >= texelFetch(map, ivec3(ivec2(texel), layer), 0).r ? 1.0 : 0.0;
    return true;
}

float visibility(uvec2 pixel, float depth) {
    Sample s = sample_at(pixel, depth);
    if (!shone_on(pixel, s)) {
        return 0.0;
    }
    float lit;
    if (look_up(s.layer, pixel, s, lit)) {
        return lit;
    }
    atomicAdd(outside, 1u);
    for (uint layer = 0u; layer < LAYERS; layer++) {
        if (look_up(layer, pixel, s, lit)) {
            return lit;
        }
    }
    return 1.0;
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, frame.size.xy))) {
        return;
    }
    float depth = texelFetch(depth_image, ivec2(pixel), 0).r;
    imageStore(visibility_image, ivec2(pixel), vec4(depth > 0.0 ? visibility(pixel, depth) : 1.0));
}
