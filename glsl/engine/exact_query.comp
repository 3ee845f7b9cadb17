#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_ray_query : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/receiver.glsl"
#include "shared/split.glsl"
layout(std140, binding = 3) uniform FrameBlock { Frame frame; };

#define RAY_BINDING 4
#include "shared/ray_query.glsl"
#include "shared/exact_trace.glsl"
