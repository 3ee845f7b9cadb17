#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/structs.glsl"

#define MATERIALS_BINDING 4
#define TEXELS_BINDING 5
#include "shared/masked_fragment.glsl"

void main() {
    if (left_out()) {
        discard;
    }
}
