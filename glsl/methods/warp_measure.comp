#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/receiver.glsl"
#include "methods/fit.glsl"
#include "methods/sample.glsl"

// What choosing the warp of each layer needs of its visible samples that the light shines on.
layout(local_size_x = 64) in;
#define WARP_BINDING 5
#include "methods/warp.glsl"
#include "methods/columns.glsl"
layout(std430, binding = 6) readonly buffer Fits { Fit fits[]; };
layout(push_constant) uniform Push {
    uint step;  // STEP_*
    float resolution;
};

// Costs are those of every eighth pixel of every eighth row, in quarters, and count no more than this.
const uint GRAIN = 8u;
const float MOST = 1023.0;

shared uint greatest[6];
shared uint sums[2];

// Lengths of a texel's two sides in pixels of the image, together. `pixels`: to pixels from a vector across the light.
float cost(Fit fit, vec2 t, mat2 pixels) {
    float q = dot(fit.row_w.xyz, vec3(t, 1.0));
    vec2 uv = vec2(dot(fit.row_u.xyz, vec3(t, 1.0)), dot(fit.row_v.xyz, vec3(t, 1.0))) / q;
    mat2 texel = pixels * inverse(fit_change(fit, uv, resolution / q));
    return min(length(texel[0]) + length(texel[1]), MOST);
}

void measure(uint layer) {
    float middle = warps[layer].middle, line = warps[layer].line;
    vec2 axis = warps[layer].axis;
    bool through_eye = warps[layer].through_eye == 1u;
    vec4 most = vec4(-1e30);
    vec2 depths = vec2(0.0, 1e30);
    float costs[2] = float[2](0.0, 0.0);
    bool any_sample = false;
    for (uint r = 0u; r < ROWS; r++) {
        uvec2 pixel;
        Sample s;
        float depth;
        if (!sample_of_row(r, pixel, s, depth) || !belongs(s, layer) || !shone_on(pixel, s)) {
            continue;
        }
        any_sample = true;
        vec2 t = light_space(0u, s.from_eye).xy;
        vec2 at = vec2(dot(vec2(axis.y, -axis.x), t), dot(axis, t));
        if (step == STEP_BOUNDS) {
            // a sample lies before the eye but for rounding
            at.x /= through_eye ? max(at.y, 1e-6 * abs(at.x)) : 1.0;
            most = max(most, vec4(-at, at));
            depths = vec2(max(depths.x, depth), min(depths.y, depth));
        } else if (step == STEP_SLOPES) {
            float slope = (at.x - middle) / (at.y - line);
            most.xy = max(most.xy, vec2(-slope, slope));
        } else if (pixel.x % GRAIN == 0u && pixel.y % GRAIN == 0u) {
            vec3 dx, dy;
            decode_derivatives(frame, texelFetch(receiver_image, ivec2(pixel), 0), depth, dx, dy);
            vec2 a = turned(0u, dx).xy, b = turned(0u, dy).xy;
            float area = a.x * b.y - a.y * b.x;
            // what the light meets edge-on has no pixels of its own
            if (abs(area) > 1e-20) {
                mat2 pixels = mat2(b.y, -a.y, -b.x, a.x) * (1.0 / area);
                costs[0] += cost(fits[layer], t, pixels);
                costs[1] += cost(warps[layer].fit, t, pixels);
            }
        }
    }
    if (any_sample) {
        for (uint i = 0u; i < 4u; i++) {
            atomicMax(greatest[i], ordered(most[i]));
        }
        // positive floats are ordered as their bits
        atomicMax(greatest[4], ~floatBitsToUint(depths.y));
        atomicMax(greatest[5], floatBitsToUint(depths.x));
        for (uint i = 0u; i < 2u; i++) {
            atomicAdd(sums[i], uint(4.0 * costs[i]));
        }
    }
}

// Adds what the workgroup found.
void gather(uint layer, uint local) {
    if (step == STEP_BOUNDS && local < 6u) {
        if (local < 4u) {
            atomicMax(warps[layer].bounds[local], greatest[local]);
        } else {
            atomicMax(warps[layer].depths[local - 4u], greatest[local]);
        }
    } else if (step == STEP_SLOPES && local < 2u) {
        atomicMax(warps[layer].slopes[local], greatest[local]);
    } else if (step == STEP_COSTS && local < 2u) {
        atomicAdd(warps[layer].costs[local], sums[local]);
    }
}

void main() {
    uint local = gl_LocalInvocationIndex;
    find_layers();
    for (uint layer = 0u; layer < LAYERS; layer++) {
        if ((group_layers & 1u << layer) == 0u) {
            continue;
        }
        if (local < 6u) {
            greatest[local] = 0u;
        }
        if (local < 2u) {
            sums[local] = 0u;
        }
        barrier();
        measure(layer);
        barrier();
        gather(layer, local);
        barrier();
    }
}
