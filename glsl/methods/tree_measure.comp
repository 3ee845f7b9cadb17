#version 460
#extension GL_GOOGLE_include_directive : require

// Decides for each region of a round whether it is to be split. A workgroup for each.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint TREE_LEVELS = 1u;
layout(constant_id = 1) const uint TREE_TILES = 1u;
layout(constant_id = 2) const uint BINS = 1u;
layout(constant_id = 3) const uint RULE = 0u;  // RULE_*
#include "methods/tree.glsl"
layout(std430, binding = 0) readonly buffer Requests { uint requests[]; };
layout(std430, binding = 1) buffer Regions { Region regions[]; };
layout(std430, binding = 2) readonly buffer State { TreeState state; };
layout(push_constant) uniform Push {
    uint round;
    float drop;      // share of a region's samples whose requests do not count
    uint threshold;  // pixels that may change without a split
    uint start;      // rounds that split whatever changed
};

const uint RULE_RECTANGLES = 0u;  // along each axis by the levels that its samples need along it
const uint RULE_SQUARES = 1u;     // along both by those that they need along either
const uint RULE_CHANGED = 2u;     // along both, by the pixels that changed

shared uint samples[4];
shared uint finer[2];  // samples that need finer texels than the region's own, along u and along v

void main() {
    uint i = gl_WorkGroupID.x, local = gl_LocalInvocationIndex;
    if (i >= state.counts[round]) {
        return;
    }
    if (local < 4u) {
        samples[local] = 0u;
    }
    if (local < 2u) {
        finer[local] = 0u;
    }
    barrier();
    uint own = region_at(round, i);
    uvec2 low = regions[own].low, size = regions[own].size;
    uvec2 levels = TREE_LEVELS - uvec2(findMSB(size));
    uint entries = 1u << 2u * TREE_LEVELS;
    uvec2 sum = uvec2(0u);
    for (uint e = local; e < size.x * size.y; e += 64u) {
        uvec2 inside = uvec2(e % size.x, e / size.x);
        uint entry = entry_at(low + inside);
        uint count = 0u;
        for (uint bin = 0u; bin < BINS; bin++) {
            uint along_u = requests[bin * entries + entry];
            count += along_u;
            sum.x += bin > levels.x ? along_u : 0u;
            if (BINS > 1u) {
                sum.y += bin > levels.y ? requests[(BINS + bin) * entries + entry] : 0u;
            }
        }
        bvec2 high = greaterThanEqual(2u * inside + 1u, size + 1u);
        if (count > 0u) {
            atomicAdd(samples[(high.x ? 1u : 0u) + (high.y ? 2u : 0u)], count);
        }
    }
    if (BINS > 1u && sum != uvec2(0u)) {
        atomicAdd(finer[0], sum.x);
        atomicAdd(finer[1], sum.y);
    }
    barrier();
    if (local != 0u) {
        return;
    }
    uint all = samples[0] + samples[1] + samples[2] + samples[3];
    uint wanted, priority;
    if (RULE == RULE_CHANGED) {
        bool split = round <= start ? all > 0u : regions[own].changed > threshold;
        wanted = split ? SPLIT_U | SPLIT_V : 0u;
        priority = round <= start ? all : regions[own].changed;
    } else {
        uint dropped = uint(drop * float(all));
        wanted = (finer[0] > dropped ? SPLIT_U : 0u) | (finer[1] > dropped ? SPLIT_V : 0u);
        wanted = RULE == RULE_SQUARES && wanted != 0u ? SPLIT_U | SPLIT_V : wanted;
        priority = max(finer[0], finer[1]);
    }
    uint possible = (size.x > 1u ? SPLIT_U : 0u) | (size.y > 1u ? SPLIT_V : 0u);
    regions[own].samples = samples;
    regions[own].splits = wanted & possible;
    regions[own].priority = priority;
    regions[own].unmet = wanted & ~possible;
}
