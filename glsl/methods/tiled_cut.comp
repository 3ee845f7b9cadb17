#version 460
#extension GL_GOOGLE_include_directive : require
#include "methods/fit.glsl"

// Cuts each region of a round in two of the same importance, or as near to that as whole entries allow, across its longer side.
// A workgroup for each.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint TREE_LEVELS = 1u;
layout(constant_id = 1) const uint TREE_TILES = 1u;
#include "methods/tree.glsl"
layout(std430, binding = 0) readonly buffer Requests { uint importance[]; };
layout(std430, binding = 1) buffer Regions { Region regions[]; };
layout(std430, binding = 2) buffer State { TreeState state; };
layout(std430, binding = 3) readonly buffer Root { Fit root; };
layout(push_constant) uniform Push { uint round; };

const uint MOST_ENTRIES = 256u;
shared uint slices[MOST_ENTRIES];

void main() {
    uint i = gl_WorkGroupID.x, local = gl_LocalInvocationIndex;
    uvec2 low = regions[region_at(round, i)].low, size = regions[region_at(round, i)].size;
    vec2 extent = vec2(size) * root.texel.xy;
    uint axis = size.x > 1u && (extent.x >= extent.y || size.y <= 1u) ? 0u : 1u;
    for (uint at = local; at < size[axis]; at += 64u) {
        uint sum = 0u;
        for (uint other = 0u; other < size[1u - axis]; other++) {
            sum += importance[entry_at(low + (axis == 0u ? uvec2(at, other) : uvec2(other, at)))];
        }
        slices[at] = sum;
    }
    barrier();
    if (local != 0u) {
        return;
    }
    uint all = 0u;
    for (uint at = 0u; at < size[axis]; at++) {
        all += slices[at];
    }
    // the first part ends before the slice that would bring it farther from a half
    uint cut = min(1u, size[axis]), before = size[axis] > 0u ? slices[0] : 0u;
    while (cut + 1u < size[axis] && abs(int(all) - 2 * int(before + slices[cut])) <= abs(int(all) - 2 * int(before))) {
        before += slices[cut];
        cut++;
    }
    uvec2 step = axis == 0u ? uvec2(1u, 0u) : uvec2(0u, 1u);
    uvec2 rest = size - cut * step;
    Region part = Region(low, size - (size[axis] - cut) * step, uint[4](0u, 0u, 0u, 0u), 0u, before, 0u, 0u);
    regions[region_at(round + 1u, 2u * i)] = part;
    // of a single entry nothing is left
    regions[region_at(round + 1u, 2u * i + 1u)] = Region(low + cut * step, rest, uint[4](0u, 0u, 0u, 0u), 0u, all - before, 0u, 0u);
    if (i == 0u) {
        state.counts[round + 1u] = 2u * state.counts[round];
    }
}
