#version 460
#extension GL_GOOGLE_include_directive : require
#include "methods/tile.glsl"

// Counts for each tile the pixels whose visibility differs from what the rounds before left (Giegl, Wimmer 2007b; book, 4.4.1), and
// takes over the new one. Pixels without a tile in this round keep what they have.
layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const uint TREE_TILES = 1u;
const uint TREE_LEVELS = 0u;
#include "methods/tree.glsl"
layout(std430, binding = 0) readonly buffer Picked { uint picked[]; };
layout(std430, binding = 1) buffer Regions { Region regions[]; };
layout(std430, binding = 2) buffer Kept { float kept[]; };  // visibility, then the round that it is of, of each pixel
layout(binding = 3, r32f) uniform image2D visibility_image;
layout(push_constant) uniform Push {
    uint round;
    uint start;  // the first round that is drawn
};

// Filtered visibility changes a little almost everywhere in penumbrae.
const float CHANGE = 0.125;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(visibility_image);
    if (any(greaterThanEqual(pixel, size))) {
        return;
    }
    uint at = uint(pixel.y * size.x + pixel.x), count = uint(size.x * size.y);
    uint tile = picked[at];
    float now = imageLoad(visibility_image, pixel).r;
    if (tile < TREE_TILES) {
        if (round > start && abs(now - kept[at]) > CHANGE) {
            atomicAdd(regions[region_at(round, tile)].changed, 1u);
        }
        kept[at] = now;
        kept[count + at] = float(round);
    } else if (round == start) {
        kept[at] = now;
        kept[count + at] = 0.0;
    } else {
        imageStore(visibility_image, pixel, vec4(kept[at]));
    }
}
