#version 460
#extension GL_GOOGLE_include_directive : require
#include "methods/fit.glsl"
#include "methods/ordered.glsl"

// Takes the rotation whose bounds have the least area, for each layer.
layout(local_size_x = 1) in;
layout(std430, binding = 0) readonly buffer Bounds { uint bounds[]; };
layout(std430, binding = 1) writeonly buffer Fits { Fit fits[]; };
layout(push_constant) uniform Push {
    float resolution;
    float border;  // texels
};

const uint ANGLES = 16u;

void main() {
    float least = 1e38;
    Fit best = Fit(vec4(0.0, 0.0, 2.0, 0.0), vec4(0.0, 0.0, 2.0, 0.0), vec4(0.0, 0.0, 1.0, 0.0), vec4(0.0));  // no sample: everything falls outside
    for (uint a = 0u; a < ANGLES; a++) {
        uint at = 4u * (gl_WorkGroupID.x * ANGLES + a);
        if (bounds[at] == 0u) {
            continue;
        }
        vec2 low = -vec2(unordered(bounds[at]), unordered(bounds[at + 1u]));
        vec2 high = vec2(unordered(bounds[at + 2u]), unordered(bounds[at + 3u]));
        // a border for filters, and so that rounding keeps every sample inside
        // few samples far from the origin: a texel is longer than what coordinates are rounded by
        float least_size = 5e-7 * resolution * length(max(abs(low), abs(high)));
        vec2 size = max((high - low) * (resolution / (resolution - 2.0 * border)), vec2(least_size));
        low = 0.5 * (low + high) - 0.5 * size;
        float area = size.x * size.y;
        if (area < least) {
            least = area;
            float angle = float(a) * (1.57079632679 / float(ANGLES));
            best.row_u = vec4(cos(angle) / size.x, sin(angle) / size.x, -low.x / size.x, 0.0);
            best.row_v = vec4(-sin(angle) / size.y, cos(angle) / size.y, -low.y / size.y, 0.0);
            best.texel = vec4(size / resolution, 0.0, 0.0);
        }
    }
    fits[gl_WorkGroupID.x] = best;
}
