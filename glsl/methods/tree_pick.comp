#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/receiver.glsl"
#include "methods/fit.glsl"
#include "methods/sample.glsl"
#include "methods/tile.glsl"

// The tile of a round that serves each visible sample.
layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 6) const uint TREE_LEVELS = 1u;
const uint TREE_TILES = 0u;
#include "methods/tree.glsl"
layout(std430, binding = 5) readonly buffer Root { Fit root; };
layout(std430, binding = 6) readonly buffer Table { uint table[]; };
layout(std430, binding = 7) writeonly buffer Picked { uint picked[]; };
layout(push_constant) uniform Push { uint round; };

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, frame.size.xy))) {
        return;
    }
    uint tile = NO_TILE;
    float depth = texelFetch(depth_image, ivec2(pixel), 0).r;
    if (depth > 0.0) {
        vec3 t = vec3(light_space(0u, pixel_ray(frame, pixel) * depth).xy, 1.0);
        float side = float(1u << TREE_LEVELS);
        vec2 at = vec2(dot(root.row_u.xyz, t), dot(root.row_v.xyz, t)) * side;
        uint word = table[entry_at(uvec2(clamp(at, vec2(0.0), vec2(side - 1.0))))];
        if (word != 0u) {
            tile = word >> 16 == round + 1u ? word & 0xffffu : KEPT_TILE;
        }
    }
    picked[pixel.y * frame.size.x + pixel.x] = tile;
}
