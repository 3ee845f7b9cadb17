#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/key.glsl"
#include "shared/receiver.glsl"
#include "methods/fit.glsl"
#include "methods/sample.glsl"
#include "methods/bias.glsl"
#include "methods/tile.glsl"

// A lookup with receiver-plane bias: the nearest texel, or a kernel around it; 1 where there is no surface or no layer holds the sample.
layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 2) const uint FILTER = 0u;
layout(constant_id = 3) const uint TAPS = 4u;
layout(constant_id = 4) const uint BIAS = 0u;  // BIAS_*
layout(constant_id = 6) const uint TILES = 0u;  // 1: each sample's layer was picked
layout(std430, binding = 5) readonly buffer Fits { Fit fits[]; };
layout(binding = 6) uniform sampler2DArray map;
layout(binding = 7, r32f) writeonly uniform image2D visibility_image;
layout(binding = 8) uniform sampler2DArray second_map;  // with BIAS_MIDPOINT and BIAS_DUAL
layout(std430, binding = 9) readonly buffer Picked { uint picked[]; };  // with TILES
layout(constant_id = 7) const uint SILHOUETTES = 0u;
layout(binding = 10) uniform sampler2DArray silhouette_map;  // with SILHOUETTES

#include "methods/silhouette_lookup.glsl"

uint layer_count(uvec2 layers) { return 1u; }
uint layer_of(uvec2 layers, uint i) { return layers.x; }
vec4 layer_quad(uint layer, vec2 low) {
    // the gather of a nearest sampler: its four texels meet at the coordinate given
    return textureGather(map, vec3((low + 1.0) / vec2(textureSize(map, 0).xy), float(layer)), 0).wzxy;
}
float layer_depth(uint layer, vec2 texel) { return texelFetch(map, ivec3(texel, layer), 0).r; }

#include "shared/kernel.glsl"

// The z that was stored as a depth, times what divides it there.
float z_of(float depth) {
    if (has_position()) {
        return depth > 0.0 ? light.depth.y / depth : light.rule.z;
    }
    return (depth - light.depth.y) / light.depth.x;
}

// A sample as a layer holds it.
struct Held {
    float z;      // in light space, world units
    float q;      // what divides stored depths
    float size;   // of a texel, world units
    vec2 slope;   // change of z to the next texel, in the receiver's plane
    Plane plane;  // stored depth over the texels, nearer to the light by the bias; with BIAS_PLANE
};

// Whether a texel lets light pass to a sample.
bool lit_by(uint layer, Held held, ivec2 texel) {
    float caster = texelFetch(map, ivec3(texel, layer), 0).r;
    if (BIAS == BIAS_PLANE) {
        return held.plane.depth + dot(held.plane.slope, vec2(texel) + 0.5 - held.plane.texel) >= caster;
    }
    float nearest = z_of(caster * held.q);
    // rounding
    float stored = nearest + light.rule.y;
    if (BIAS == BIAS_CONSTANT) {
        stored += light.rule.x * held.size;
    } else if (BIAS == BIAS_SLOPE) {
        stored += light.rule.x * (0.25 * held.size + 0.5 * (abs(held.slope.x) + abs(held.slope.y)));
    } else if (BIAS == BIAS_MIDPOINT || BIAS == BIAS_DUAL) {
        float behind = 0.5 * (z_of(texelFetch(second_map, ivec3(texel, layer), 0).r * held.q) - nearest);
        stored += BIAS == BIAS_DUAL ? min(behind, light.rule.x * held.size) : behind;
    }
    return held.z <= stored;
}

// By the four texels around a sample, or, where they differ, by the one that the silhouettes between them leave to it.
bool lit_by_corners(uint layer, Held held, vec2 at) {
    vec2 p = at - 0.5;
    ivec2 low = ivec2(floor(p));
    ivec2 last = textureSize(map, 0).xy - 1;
    bool lit[4];
    for (int i = 0; i < 4; i++) {
        lit[i] = lit_by(layer, held, clamp(low + ivec2(i & 1, i >> 1), ivec2(0), last));
    }
    if (lit[0] == lit[1] && lit[1] == lit[2] && lit[2] == lit[3]) {
        return lit[0];
    }
    ivec2 corner = corner_of(layer, low, p - vec2(low));
    return lit[corner.x + 2 * corner.y];
}

// False where the layer does not hold the sample.
bool look_up(uint layer, uvec2 pixel, Sample s, out float lit) {
    uint face = face_of(layer);
    vec3 ls = light_space(face, s.from_eye);
    float w = divisor(ls.z);
    vec3 t = vec3(ls.xy / w, 1.0);
    Fit fit = fits[layer];
    float q = dot(fit.row_w.xyz, t);
    vec2 uv = vec2(dot(fit.row_u.xyz, t), dot(fit.row_v.xyz, t)) / q;
    if (w <= 0.0 || q <= 0.0 || any(lessThan(uv, vec2(0.0))) || any(greaterThanEqual(uv, vec2(1.0)))) {
        return false;
    }
    vec3 normal = turned(face, s.normal);
    float side = float(textureSize(map, 0).x);
    vec2 texel = uv * side;
    // change of t from a texel to the next, along u and along v
    mat2 along = inverse(fit_change(fit, uv, side / q));
    vec2 size = w * vec2(length(along[0]), length(along[1]));
    // change of z per unit across, in the receiver's plane at constant x / w and y / w
    float facing = has_position() ? dot(normal, ls) : normal.z;
    vec2 across = clamp(-normal.xy * w / facing, -200.0, 200.0);
    vec2 slope = w * vec2(dot(across, along[0]), dot(across, along[1]));
    float bias = light.rule.x * receiver_bias(max(size.x, size.y), slope) + light.rule.y;
    // stored depth is affine over the receiver's plane
    float nearer = has_position() ? max(ls.z - bias, 1e-6 * ls.z) : ls.z - bias;
    float per_z = has_position() ? -light.depth.y / (ls.z * ls.z) : light.depth.x;
    float depth = stored_depth(nearer) / q;
    vec2 change = (slope * per_z - depth * vec2(dot(fit.row_w.xy, along[0]), dot(fit.row_w.xy, along[1]))) / q;
    Held held = Held(ls.z, q, max(size.x, size.y), slope, Plane(texel, depth, change, 0.0));
    if (FILTER != FILTER_HARD) {
        lit = kernel_visibility(held.plane, uvec2(layer, 0u), pixel);
    } else {
        lit = (SILHOUETTES == 1u ? lit_by_corners(layer, held, texel) : lit_by(layer, held, ivec2(texel))) ? 1.0 : 0.0;
    }
    return true;
}

float visibility(uvec2 pixel, float depth) {
    Sample s = sample_at(pixel, depth);
    if (!shone_on(pixel, s)) {
        return 0.0;
    }
    float lit;
    if (TILES == 1u) {
        s.layer = picked[pixel.y * frame.size.x + pixel.x];
        if (s.layer == KEPT_TILE) {
            return 1.0;
        }
        if (s.layer != NO_TILE && look_up(s.layer, pixel, s, lit)) {
            return lit;
        }
        atomicAdd(outside, 1u);
        return 1.0;
    }
    if (look_up(s.layer, pixel, s, lit)) {
        float next;
        return s.next > 0.0 && look_up(s.layer + 1u, pixel, s, next) ? mix(lit, next, s.next) : lit;
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
