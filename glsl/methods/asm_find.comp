#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/receiver.glsl"
#include "methods/fit.glsl"
#include "methods/asm_samples.glsl"
#include "methods/tile.glsl"

// The tile of each pixel: the finest that holds its sample. Tiles no finer than their samples ask for are in use.
layout(local_size_x = 8, local_size_y = 8) in;
layout(std430, binding = 7) buffer TilePages { TilePage pages[]; };
layout(std430, binding = 8) writeonly buffer Picked { uint picked[]; };

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, frame.size.xy))) {
        return;
    }
    Served s;
    uint tile = NO_TILE;
    if (served_sample(pixel, s)) {
        tile = s.tile;
        if (pages[tile].used != virtual_map.frame && (s.depth <= s.needed || s.depth == ROOT_DEPTH)) {
            pages[tile].used = virtual_map.frame;
        }
    }
    picked[pixel.y * frame.size.x + pixel.x] = tile;
}
