#version 460
#extension GL_GOOGLE_include_directive : require
#define RESIZED
#include "methods/map_sampling.glsl"

// Of tiles that were drawn level by level: a pixel's is that of the round whose visibility it kept, a square of the root.
layout(constant_id = 7) const float SHARE = 1.0;  // of a tile's side that samples may fall on
layout(std430, binding = 8) readonly buffer Kept { float kept[]; };  // as in qvsm_compare.comp

uint round_of() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    return uint(kept[frame.size.x * frame.size.y + pixel.y * frame.size.x + pixel.x]);
}

vec2 texels_of(vec2 uv) { return vec2(SHARE * float(1u << round_of())); }

uint part_of(uint layer, vec2 uv) {
    uvec2 tile = uvec2(uv * float(1u << round_of()));
    return tile.x | tile.y << 8 | round_of() << 16;
}
