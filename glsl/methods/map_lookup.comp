#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/key.glsl"
#include "shared/receiver.glsl"
#include "methods/fit.glsl"
#include "methods/sample.glsl"
#include "methods/bias.glsl"
#include "methods/layer_plane.glsl"
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

// Whether a sample is lit without a look at its plane elsewhere. `size`: of a texel, `slope`: change of z to the next; world
// units; `q`: what divides stored depths.
bool lit_by_depth(uint layer, float z, ivec2 texel, float size, vec2 slope, float q) {
    float nearest = z_of(texelFetch(map, ivec3(texel, layer), 0).r * q);
    // rounding
    float stored = nearest + light.rule.y;
    if (BIAS == BIAS_CONSTANT) {
        stored += light.rule.x * size;
    } else if (BIAS == BIAS_SLOPE) {
        stored += light.rule.x * (0.25 * size + 0.5 * (abs(slope.x) + abs(slope.y)));
    } else if (BIAS == BIAS_MIDPOINT || BIAS == BIAS_DUAL) {
        float behind = 0.5 * (z_of(texelFetch(second_map, ivec3(texel, layer), 0).r * q) - nearest);
        stored += BIAS == BIAS_DUAL ? min(behind, light.rule.x * size) : behind;
    }
    return z <= stored;
}

// False where the layer does not hold the sample.
bool look_up(uint layer, uvec2 pixel, Sample s, out float lit) {
    Fit fit = fits[layer];
    LayerPlace p;
    if (!place_in_layer(fit, face_of(layer), s, float(textureSize(map, 0).x), p)) {
        return false;
    }
    if (BIAS != BIAS_PLANE) {
        lit = lit_by_depth(layer, p.ls.z, ivec2(p.texel), max(p.size.x, p.size.y), p.slope, p.q) ? 1.0 : 0.0;
        return true;
    }
    Plane plane = receiver_plane(fit, p);
    if (FILTER != FILTER_HARD) {
        lit = kernel_visibility(plane, uvec2(layer, 0u), pixel);
    } else {
        float caster = texelFetch(map, ivec3(ivec2(plane.texel), layer), 0).r;
        lit = plane.depth + dot(plane.slope, floor(plane.texel) + 0.5 - plane.texel) >= caster ? 1.0 : 0.0;
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
