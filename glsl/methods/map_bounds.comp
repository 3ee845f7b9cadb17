#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/receiver.glsl"
#include "methods/sample.glsl"
#include "methods/ordered.glsl"

// Bounds of the visible samples that the light shines on, across the light, for each layer and 16 rotations of the map.
// A thread walks down 32 pixels of a column, once for each layer that its workgroup meets.
layout(local_size_x = 64) in;
// per layer and rotation: low u, low v, high u, high v; ordered bits
layout(std430, binding = 5) buffer Bounds { uint bounds[]; };

const uint ANGLES = 16u;
const uint ROWS = 32u;
shared uint group_bounds[4u * ANGLES];
shared uint group_layers;  // bit i: the workgroup has samples of layer i

// Row r of the thread's column: false where there is no surface.
bool sample_of_row(uint r, out uvec2 pixel, out float depth, out Sample s) {
    pixel = uvec2(gl_GlobalInvocationID.x, gl_WorkGroupID.y * ROWS + r);
    depth = all(lessThan(pixel, frame.size.xy)) ? texelFetch(depth_image, ivec2(pixel), 0).r : 0.0;
    s = sample_at(pixel, depth);
    return depth > 0.0;
}

void measure(uint layer) {
    // "low" is kept as the maximum of the negated coordinate
    vec2 high[ANGLES];
    vec2 low[ANGLES];
    for (uint a = 0u; a < ANGLES; a++) {
        high[a] = vec2(-1e30);
        low[a] = vec2(-1e30);
    }
    bool any_sample = false;
    for (uint r = 0u; r < ROWS; r++) {
        uvec2 pixel;
        float depth;
        Sample s;
        if (!sample_of_row(r, pixel, depth, s) || !(s.layer == layer || s.next > 0.0 && s.layer + 1u == layer) || !shone_on(pixel, s)) {
            continue;
        }
        any_sample = true;
        for (uint i = 0u; i < SAMPLES; i++) {
            vec3 ls = light_space(face_of(layer), ray_start(sample_point(i, pixel, depth, s), s));
            vec2 t = ls.xy / divisor(ls.z);
            for (uint a = 0u; a < ANGLES; a++) {
                float angle = float(a) * (1.57079632679 / float(ANGLES));
                vec2 uv = vec2(cos(angle) * t.x + sin(angle) * t.y, cos(angle) * t.y - sin(angle) * t.x);
                high[a] = max(high[a], uv);
                low[a] = max(low[a], -uv);
            }
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
}

void main() {
    uint local = gl_LocalInvocationIndex;
    if (local == 0u) {
        group_layers = LAYERS > 1u ? 0u : 1u;
    }
    barrier();
    if (LAYERS > 1u) {
        uint met = 0u;
        for (uint r = 0u; r < ROWS; r++) {
            uvec2 pixel;
            float depth;
            Sample s;
            if (sample_of_row(r, pixel, depth, s)) {
                met |= (s.next > 0.0 ? 3u : 1u) << s.layer;
            }
        }
        atomicOr(group_layers, met);
        barrier();
    }
    for (uint layer = 0u; layer < LAYERS; layer++) {
        if ((group_layers & 1u << layer) == 0u) {
            continue;
        }
        group_bounds[local] = 0u;
        barrier();
        measure(layer);
        barrier();
        if (group_bounds[local] != 0u) {
            atomicMax(bounds[4u * ANGLES * layer + local], group_bounds[local]);
        }
        barrier();
    }
}
