#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/structs.glsl"

#define MATERIALS_BINDING 5
#define TEXELS_BINDING 6
#include "shared/masked_fragment.glsl"
