#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "methods/fit.glsl"

// Takes the rotation whose bounds have the least area.
layout(local_size_x = 1) in;
layout(std430, binding = 0) readonly buffer Bounds { uint bounds[64]; };
layout(std430, binding = 1) writeonly buffer FitBlock { Fit fit; };
layout(push_constant) uniform Push { float resolution; };

float unordered(uint bits) { return uintBitsToFloat((bits & 0x80000000u) != 0u ? bits & 0x7fffffffu : ~bits); }

void main() {
    float least = 1e38;
    Fit best = Fit(vec4(0.0, 0.0, 2.0, 0.0), vec4(0.0, 0.0, 2.0, 0.0), vec4(1.0));  // no sample: everything falls outside
    for (uint a = 0u; a < 16u; a++) {
        if (bounds[4u * a] == 0u) {
            continue;
        }
        vec2 low = -vec2(unordered(bounds[4u * a]), unordered(bounds[4u * a + 1u]));
        vec2 high = vec2(unordered(bounds[4u * a + 2u]), unordered(bounds[4u * a + 3u]));
        // one texel of border, so that rounding keeps every sample inside
        vec2 size = max((high - low) * (resolution / (resolution - 2.0)), vec2(1e-6 * length(max(abs(low), abs(high)))));
        low = 0.5 * (low + high) - 0.5 * size;
        float area = size.x * size.y;
        if (area < least) {
            least = area;
            float angle = float(a) * (1.57079632679 / 16.0);
            best.row_u = vec4(cos(angle) / size.x, sin(angle) / size.x, -low.x / size.x, 0.0);
            best.row_v = vec4(-sin(angle) / size.y, cos(angle) / size.y, -low.y / size.y, 0.0);
            best.texel = vec4(size / resolution, 0.0, 0.0);
        }
    }
    fit = best;
}
