// What both stages of the draw of the casters need.
layout(constant_id = 0) const uint LAYER = 0u;
layout(constant_id = 6) const uint SAMPLES = 1u;
layout(constant_id = 7) const bool ALPHA = false;  // whether the casters are alpha tested
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
#define LIGHT_BINDING 1
#include "methods/light.glsl"
layout(std430, binding = 2) readonly buffer Fits { Fit fits[]; };
#define RAY_BINDING 2
#define RAY_CONSTANT 3
#include "shared/ray_hit.glsl"
layout(std430, binding = 8) readonly buffer Indices { uint indices[]; };
