// What the passes need that find the triangle under each pixel: instance, and triangle of the scene + 1, or 0.
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
#define RAY_BINDING 0
#define RAY_CONSTANT 0
#include "shared/ray_hit.glsl"
layout(std430, binding = 6) readonly buffer Indices { uint indices[]; };
