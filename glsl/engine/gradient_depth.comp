#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/receiver.glsl"

// Without normals: a pixel's plane goes through its neighbours, on either side of each axis the one that lies on one line with
// the next beyond it (stored depth is affine across the image of a plane).
layout(local_size_x = 8, local_size_y = 8) in;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(binding = 1) uniform sampler2D depth_image;

#include "shared/receiver_plane.glsl"

const float NONE = 1e30;
// Share by which the changes on both sides of a pixel may differ on one plane.
const float STRAIGHT = 0.05;

// Stored depth of a pixel, NONE where there is no surface.
float stored_at(ivec2 pixel) {
    if (any(lessThan(pixel, ivec2(0))) || any(greaterThanEqual(pixel, ivec2(frame.size.xy)))) {
        return NONE;
    }
    float stored = texelFetch(depth_image, pixel, 0).r;
    return is_surface(frame, stored) ? stored : NONE;
}

// Change of stored depth from a pixel to the next along an axis, from the side that continues in a line; 0 without either.
float slope(ivec2 pixel, ivec2 axis, float middle) {
    vec2 side = vec2(stored_at(pixel - axis), stored_at(pixel + axis));
    vec2 beyond = vec2(stored_at(pixel - 2 * axis), stored_at(pixel + 2 * axis));
    vec2 change = vec2(middle - side.x, side.y - middle);
    vec2 bend = abs(2.0 * side - beyond - middle);
    // where nothing lies beyond, the lesser change tells, after any side that has a line
    bend = mix(bend, NONE * (0.5 + 0.1 * min(abs(change), vec2(1.0))), equal(beyond, vec2(NONE)));
    bend = mix(bend, vec2(NONE), equal(side, vec2(NONE)));
    if (min(bend.x, bend.y) >= NONE) {
        return 0.0;
    }
    // where the two sides are one line, their mean halves the rounding of depths
    if (max(bend.x, bend.y) < 0.5 * NONE && abs(change.x - change.y) <= STRAIGHT * abs(change.x + change.y)) {
        return 0.5 * (change.x + change.y);
    }
    return bend.x < bend.y ? change.x : change.y;
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, frame.size.xy))) {
        return;
    }
    float stored = stored_at(ivec2(pixel));
    if (stored == NONE) {
        store_nothing(pixel);
        return;
    }
    float depth = linear_depth(frame, stored);
    vec3 ray = pixel_ray(frame, pixel);
    // depth is w / (stored + c), so its derivative is -depth^2 / w times that of the stored one
    float rate = -depth / frame.ray_corner.w;
    vec3 dx = frame.ray_dx.xyz + ray * rate * slope(ivec2(pixel), ivec2(1, 0), stored);
    vec3 dy = frame.ray_dy.xyz + ray * rate * slope(ivec2(pixel), ivec2(0, 1), stored);
    vec3 n = normalize(cross(dx, dy));
    store_plane(pixel, depth, umbrage_encode_normal(dot(n, ray) > 0.0 ? -n : n));
}
