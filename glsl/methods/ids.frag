#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/structs.glsl"

// The nearest triangle: instance, and triangle of the scene + 1; what is cleared is 0. Floats are exact up to 2^24.
#define MATERIALS_BINDING 4
#define TEXELS_BINDING 5
#include "shared/masked_fragment.glsl"
layout(location = 4) flat in vec2 triangle;
layout(location = 0) out vec2 seen;

void main() {
    if (left_out()) {
        discard;
    }
    seen = triangle;
}
