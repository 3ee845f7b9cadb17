#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"

// Admits pages, coarse ones first, while their pairs fit the budget; gives each its range of pairs; writes the
// arguments of everything that follows. One workgroup.
layout(local_size_x = 256) in;
layout(constant_id = 0) const uint PAIR_CAPACITY = 1024u;
layout(constant_id = 1) const uint DISPATCH_X = 32768u;
layout(std430, binding = 0) buffer CountersBlock { Counters counters; };
layout(std430, binding = 1) buffer Pages { Page pages[]; };
layout(std430, binding = 2) buffer PairCursors { uint pair_cursors[]; };
layout(std430, binding = 3) writeonly buffer Arguments { uint arguments[]; };
layout(push_constant) uniform Push { uint argument; };  // first of 4 + 3 + 3 words: clear draw, triangles of both kinds

shared uvec2 sums[256];
shared uvec2 total;

void write_dispatch(uint at, uint count) {
    arguments[at] = min(count, DISPATCH_X);
    arguments[at + 1u] = (count + DISPATCH_X - 1u) / DISPATCH_X;
    arguments[at + 2u] = 1u;
}

void main() {
    uint local = gl_LocalInvocationIndex;
    uint share = (counters.sorted + 255u) / 256u;
    uint begin = min(local * share, counters.sorted);
    uint end = min(begin + share, counters.sorted);
    uvec2 sum = uvec2(0u);
    for (uint i = begin; i < end; i++) {
        sum += uvec2(pair_cursors[2u * i], pair_cursors[2u * i + 1u]);
    }
    sums[local] = sum;
    if (local == 0u) {
        total = uvec2(0u);
    }
    barrier();
    for (uint step = 1u; step < 256u; step *= 2u) {
        uvec2 before = local >= step ? sums[local - step] : uvec2(0u);
        barrier();
        sums[local] += before;
        barrier();
    }
    sum = sums[local] - sum;
    for (uint i = begin; i < end; i++) {
        uvec2 count = uvec2(pair_cursors[2u * i], pair_cursors[2u * i + 1u]);
        uvec2 after = sum + count;
        bool fits = after.x + after.y <= PAIR_CAPACITY;
        pages[i].admitted = fits ? 1u : 0u;
        if (fits) {
            pair_cursors[2u * i] = sum.x;
            pair_cursors[2u * i + 1u] = sum.y;
            atomicAdd(counters.admitted, 1u);
            atomicAdd(counters.resident[key_level(pages[i].key)], 1u);
            atomicMax(total.x, after.x);
            atomicMax(total.y, after.y);
        }
        sum = after;
    }
    barrier();
    if (local == 255u) {
        counters.pairs_asked = sums[255].x + sums[255].y;
        counters.pairs_opaque = total.x;
        counters.pairs_masked = total.y;
        arguments[argument] = 3u;
        arguments[argument + 1u] = counters.sorted;
        arguments[argument + 2u] = 0u;
        arguments[argument + 3u] = 0u;
        write_dispatch(argument + 4u, total.x);
        write_dispatch(argument + 7u, total.y);
    }
}
