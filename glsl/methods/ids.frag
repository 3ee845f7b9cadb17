#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/structs.glsl"

// The number of the nearest triangle, counted from 1; what is cleared is 0.
#define MATERIALS_BINDING 4
#define TEXELS_BINDING 5
#include "shared/masked_fragment.glsl"
layout(location = 4) flat in float polygon;
layout(location = 0) out float id;

void main() {
    if (left_out()) {
        discard;
    }
    id = polygon;
}
