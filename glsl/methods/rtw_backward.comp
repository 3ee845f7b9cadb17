#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/receiver.glsl"
#include "methods/fit.glsl"
#include "methods/sample.glsl"
#include "methods/rtw_importance.glsl"

// Backward analysis (Rosen 2012, 4.1): the importance of what the camera sees and the light shines on, the greatest for each cell.
layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 2) const uint CELLS = 512u;
layout(std430, binding = 5) readonly buffer Fits { Fit fits[]; };
layout(std430, binding = 6) buffer Importance { uint importance[]; };  // CELLS rows along v; floats, which are not negative

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy * stride + stride / 2u;
    if (any(greaterThanEqual(pixel, frame.size.xy))) {
        return;
    }
    float depth = texelFetch(depth_image, ivec2(pixel), 0).r;
    Sample s = sample_at(pixel, depth);
    if (depth <= 0.0 || !shone_on(pixel, s)) {
        return;
    }
    vec3 t = vec3(light_space(0u, s.from_eye).xy, 1.0);
    vec2 uv = vec2(dot(fits[0].row_u.xyz, t), dot(fits[0].row_v.xyz, t));
    uvec2 cell = uvec2(clamp(uv * float(CELLS), vec2(0.0), vec2(float(CELLS - 1u))));
    // floats that are not negative are ordered as their bits
    atomicMax(importance[cell.y * CELLS + cell.x], floatBitsToUint(seen_importance(s.from_eye, s.normal, depth)));
}
