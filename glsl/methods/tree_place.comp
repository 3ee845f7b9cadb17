#version 460
#extension GL_GOOGLE_include_directive : require
#include "methods/fit.glsl"

// Places the tiles of a round: a layer for each region, which the tile fills but for a border. A workgroup for each layer.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint TREE_LEVELS = 1u;
layout(constant_id = 1) const uint TREE_TILES = 1u;
layout(constant_id = 2) const float SIDE = 1.0;    // texels
layout(constant_id = 3) const float BORDER = 1.0;  // texels
#include "methods/tree.glsl"
layout(std430, binding = 0) readonly buffer Root { Fit root; };
layout(std430, binding = 1) readonly buffer Regions { Region regions[]; };
layout(std430, binding = 2) readonly buffer State { TreeState state; };
layout(std430, binding = 3) writeonly buffer Fits { Fit fits[]; };
layout(std430, binding = 4) writeonly buffer Drawn { uint drawn[]; };
layout(std430, binding = 5) writeonly buffer Table { uint table[]; };  // from entries to tiles, see tile_word
layout(push_constant) uniform Push { uint round; };

void main() {
    uint tile = gl_WorkGroupID.x;
    // a region without entries is none
    bool used = tile < state.counts[round] && all(greaterThan(regions[region_at(round, tile)].size, uvec2(0u)));
    if (gl_LocalInvocationIndex == 0u) {
        drawn[tile] = used ? 1u : 0u;
    }
    if (!used) {
        if (gl_LocalInvocationIndex == 0u) {
            fits[tile].texel = vec4(0.0);
        }
        return;
    }
    uvec2 low = regions[region_at(round, tile)].low, size = regions[region_at(round, tile)].size;
    if (gl_LocalInvocationIndex == 0u) {
        float share = (SIDE - 2.0 * BORDER) / SIDE;
        vec2 scale = share * float(1u << TREE_LEVELS) / vec2(size);
        vec2 offset = BORDER / SIDE - share * vec2(low) / vec2(size);
        Fit fit = root;
        fit.row_u.xyz = root.row_u.xyz * scale.x + vec3(0.0, 0.0, offset.x);
        fit.row_v.xyz = root.row_v.xyz * scale.y + vec3(0.0, 0.0, offset.y);
        fit.texel.xy = root.texel.xy / scale;
        fits[tile] = fit;
    }
    for (uint e = gl_LocalInvocationIndex; e < size.x * size.y; e += 64u) {
        table[entry_at(low + uvec2(e % size.x, e / size.x))] = tile_word(round, tile);
    }
}
