#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/structs.glsl"
#include "methods/fit.glsl"
#include "methods/quadtree.glsl"
#include "methods/asm_gpu_counts.glsl"

// Leaves each page asked for once (Lefohn et al. 2005) and gives it a tile while there are any, coarse pages first; says whether
// samples are to be asked again. One workgroup; a thread takes a share of the sorted keys.
layout(local_size_x = 256) in;
layout(constant_id = 0) const uint TILES = 1024u;
layout(std430, binding = 0) buffer CountersBlock { Counters counters; };
layout(std430, binding = 1) readonly buffer Keys { uvec2 keys[]; };
layout(std430, binding = 2) buffer TilePages { TilePage pages[]; };
layout(std430, binding = 3) writeonly buffer Drawn { uint drawn[]; };
layout(std430, binding = 4) buffer Counts { AsmGpuCounts counts; };
layout(std430, binding = 5) writeonly buffer Arguments { uint arguments[]; };
layout(push_constant) uniform Push {
    uint first;     // 1: the first iteration of a frame
    uint last;      // 1: nothing is drawn any more
    uvec2 groups;   // workgroups that ask
    uint argument;  // first word of their dispatch
};

shared uint sums[256];
shared uint taken;  // tiles before this iteration

bool head(uint i) { return i == 0u || keys[i] != keys[i - 1u]; }

void main() {
    uint local = gl_LocalInvocationIndex;
    uint count = counters.sorted;
    uint share = (count + 255u) / 256u;
    uint begin = min(local * share, count);
    uint end = min(begin + share, count);
    uint own = 0u;
    for (uint i = begin; i < end; i++) {
        own += head(i) ? 1u : 0u;
    }
    sums[local] = own;
    if (local == 0u) {
        taken = first == 1u ? root_count() : counts.resident;
    }
    barrier();
    for (uint step = 1u; step < 256u; step *= 2u) {
        uint before = local >= step ? sums[local - step] : 0u;
        barrier();
        sums[local] += before;
        barrier();
    }
    uint distinct = sums[255];
    uint made = last == 1u ? 0u : min(distinct, TILES - taken);
    uint index = sums[local] - own;
    for (uint i = begin; i < end; i++) {
        if (head(i)) {
            if (index < made) {
                TilePage page = pages[taken + index];
                page.depth = keys[i].x;
                page.x = keys[i].y >> 16;
                page.y = keys[i].y & 0xffffu;
                pages[taken + index] = page;
            }
            index++;
        }
    }
    for (uint tile = local; tile < TILES; tile += 256u) {
        drawn[tile] = tile >= taken && tile < taken + made ? 1u : 0u;
    }
    if (local == 0u) {
        AsmGpuCounts c = counts;
        if (first == 1u) {
            c = AsmGpuCounts(root_count(), 0u, 0u, 0u, root_count(), 1u);
        }
        c.resident = taken + made;
        c.iterations += made > 0u ? 1u : 0u;
        c.requested += distinct;
        // what is refused is asked for again, so that only the last count of those that were asked matters
        c.outstanding = c.asking == 1u ? distinct - made : c.outstanding;
        c.asking = made > 0u ? 1u : 0u;
        counts = c;
        counters.requests[0] = 0u;
        arguments[argument] = c.asking * groups.x;
        arguments[argument + 1u] = c.asking * groups.y;
        arguments[argument + 2u] = 1u;
    }
}
