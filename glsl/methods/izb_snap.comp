#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/split.glsl"
#include "shared/receiver.glsl"
#include "methods/izb_owner.glsl"

// Moves the samples of pixels that are smaller than what single precision leaves of large triangles onto the triangle that they
// show, along their view rays; as `exact_trace.glsl` and src/truth/reference.rs.
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 7) uniform usampler2D owners;
layout(binding = 8, r32f) uniform image2D depth_image;

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, frame.size.xy))) {
        return;
    }
    float depth = imageLoad(depth_image, ivec2(pixel)).r;
    uvec2 owner = texelFetch(owners, ivec2(pixel), 0).xy;
    vec3 from_eye = pixel_ray(frame, pixel) * depth;
    if (depth <= 0.0 || owner.y == 0u || !(ray_offset(frame, from_eye) < frame.rule.w)) {
        return;
    }
    uint first = 3u * (owner.y - 1u);
    uvec3 vertices = uvec3(indices[first], indices[first + 1u], indices[first + 2u]);
    float t = plane_t(instances[owner.x], Met(owner.y - 1u, vertices, vec3(0.0)), from_eye, from_eye);
    if (abs(t) < SNAP) {
        imageStore(depth_image, ivec2(pixel), vec4(depth * (1.0 + t)));
    }
}
