#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/receiver.glsl"
#include "methods/sample.glsl"
#include "methods/ordered.glsl"
#include "methods/columns.glsl"

// Bounds of the visible samples that the light shines on, across the light, for each layer and 16 rotations of the map.
layout(local_size_x = 64) in;
// per layer and rotation: low u, low v, high u, high v; ordered bits
layout(std430, binding = 5) buffer Bounds { uint bounds[]; };

const uint ANGLES = 16u;
shared uint group_bounds[4u * ANGLES];

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
        Sample s;
        float depth;
        if (!sample_of_row(r, pixel, s, depth) || !belongs(s, layer) || !shone_on(pixel, s)) {
            continue;
        }
        any_sample = true;
        vec3 ls = light_space(face_of(layer), s.from_eye);
        vec2 t = ls.xy / divisor(ls.z);
        for (uint a = 0u; a < ANGLES; a++) {
            float angle = float(a) * (1.57079632679 / float(ANGLES));
            vec2 uv = vec2(cos(angle) * t.x + sin(angle) * t.y, cos(angle) * t.y - sin(angle) * t.x);
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
}

void main() {
    uint local = gl_LocalInvocationIndex;
    find_layers();
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
