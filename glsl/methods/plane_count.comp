#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/receiver.glsl"
#include "methods/sample.glsl"

// Counts the visible samples that the light shines on by the plane in which they lie.
layout(local_size_x = 64) in;
#include "methods/columns.glsl"
#define PLANE_BINDING 5
#include "methods/plane.glsl"
layout(std430, binding = 6) buffer Bins { uint bins[]; };

void main() {
    // rows below each other mostly are of one plane
    uint last = 0u, run = 0u;
    for (uint r = 0u; r < ROWS; r++) {
        uvec2 pixel;
        Sample s;
        float depth;
        if (!sample_of_row(r, pixel, s, depth) || !shone_on(pixel, s)) {
            continue;
        }
        uint bin = bin_of(s.normal, dot(s.normal, s.from_eye));
        if (bin != last && run > 0u) {
            atomicAdd(bins[last], run);
            run = 0u;
        }
        last = bin;
        run++;
    }
    if (run > 0u) {
        atomicAdd(bins[last], run);
    }
}
