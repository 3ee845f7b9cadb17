#version 460
#extension GL_GOOGLE_include_directive : require

// Makes the list of the next round: parts of what is to be split, without those that have no samples. Where there is no room for all
// of them, those of the highest priority are split. One workgroup.
layout(local_size_x = 256) in;
layout(constant_id = 0) const uint TREE_LEVELS = 1u;
layout(constant_id = 1) const uint TREE_TILES = 1u;
layout(constant_id = 2) const uint KEEP = 0u;  // 1: what is not split stays in the list
#include "methods/tree.glsl"
layout(std430, binding = 0) buffer Regions { Region regions[]; };
layout(std430, binding = 1) buffer State { TreeState state; };
layout(push_constant) uniform Push { uint round; };

const uint GROUP = 256u;
shared uint sums[GROUP];
shared uint refused;

// Whether the part of a region has samples. `part`: bit 0 high along u, bit 1 high along v, of what is split.
bool seen(Region region, uint part) {
    uint sum = 0u;
    for (uint quarter = 0u; quarter < 4u; quarter++) {
        sum += (quarter & region.splits) == part ? region.samples[quarter] : 0u;
    }
    return sum > 0u;
}

uint parts(Region region) {
    uint count = 0u;
    for (uint part = 0u; part < 4u; part++) {
        count += (part & ~region.splits) == 0u && seen(region, part) ? 1u : 0u;
    }
    return count;
}

// Room that the region's parts take beyond what it takes itself.
uint cost(Region region) { return region.splits != 0u ? parts(region) - KEEP : 0u; }

// Sum over all threads; all get it.
uint total(uint value) {
    sums[gl_LocalInvocationIndex] = value;
    barrier();
    uint sum = 0u;
    for (uint i = 0u; i < GROUP; i++) {
        sum += sums[i];
    }
    barrier();
    return sum;
}

// Whether a region that is to be split finds room after those that go first.
bool admitted(uint i, uint count, uint room) {
    Region own = regions[region_at(round, i)];
    uint before = 0u;
    for (uint j = 0u; j < count; j++) {
        Region other = regions[region_at(round, j)];
        bool first = other.priority > own.priority || other.priority == own.priority && j < i;
        before += other.splits != 0u && first ? cost(other) : 0u;
    }
    return before + cost(own) <= room;
}

void main() {
    uint local = gl_LocalInvocationIndex;
    uint count = state.counts[round];
    uint chunk = (count + GROUP - 1u) / GROUP;
    uint first = min(local * chunk, count), end = min(first + chunk, count);
    if (local == 0u) {
        refused = 0u;
    }
    uint costs = 0u;
    for (uint i = first; i < end; i++) {
        costs += cost(regions[region_at(round, i)]);
    }
    uint room = TREE_TILES - KEEP * count;
    bool crowded = total(costs) > room;
    // bit by bit: which of the thread's own are split
    uint split = 0u;
    uint written = 0u;
    for (uint i = first; i < end; i++) {
        Region region = regions[region_at(round, i)];
        bool goes = region.splits != 0u && (!crowded || admitted(i, count, room));
        split |= goes ? 1u << i - first : 0u;
        written += goes ? parts(region) : KEEP;
        if (region.splits != 0u && !goes) {
            atomicAdd(refused, 1u);
        }
    }
    sums[local] = written;
    barrier();
    uint at = 0u;
    for (uint i = 0u; i < local; i++) {
        at += sums[i];
    }
    for (uint i = first; i < end; i++) {
        Region region = regions[region_at(round, i)];
        uint splits = (split & 1u << i - first) != 0u ? region.splits : 0u;
        if (splits == 0u) {
            if (KEEP == 1u) {
                regions[region_at(round + 1u, at)] = region;
                at++;
            }
            continue;
        }
        uvec2 size = uvec2((splits & SPLIT_U) != 0u ? region.size.x / 2u : region.size.x, (splits & SPLIT_V) != 0u ? region.size.y / 2u : region.size.y);
        for (uint part = 0u; part < 4u; part++) {
            if ((part & ~splits) == 0u && seen(region, part)) {
                uvec2 low = region.low + size * uvec2(part & 1u, part >> 1u);
                regions[region_at(round + 1u, at)] = Region(low, size, uint[4](0u, 0u, 0u, 0u), 0u, 0u, 0u, 0u);
                at++;
            }
        }
    }
    if (local == GROUP - 1u) {
        state.counts[round + 1u] = at;
        state.refused[round] = refused;
    }
}
