#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/refine.glsl"

// Admits pages while their pairs fit the budget, gives each its range of pairs, and writes the arguments of everything
// that follows. Roots first: they answer for everything, and the engine makes the budget large enough for them. If not
// all others fit, those with the most pixels per pair. One workgroup.
layout(local_size_x = 256) in;
layout(constant_id = 0) const uint PAIR_CAPACITY = 1024u;
layout(constant_id = 1) const uint DISPATCH_X = 32768u;
layout(std430, binding = 0) buffer CountersBlock { Counters counters; };
layout(std430, binding = 1) buffer Pages { Page pages[]; };
layout(std430, binding = 2) buffer PairCursors { uint pair_cursors[]; };
layout(std430, binding = 3) writeonly buffer Arguments { uint arguments[]; };
layout(std430, binding = 4) readonly buffer Nodes { Node nodes[]; };
layout(push_constant) uniform Push { uint argument; };  // first of 4 + 3 + 3 words: clear draw, triangles of both kinds

shared uvec2 sums[256];
shared uint ranks[RANKS];  // pairs of the pages of each rank
shared uint asked;
shared uint roots;
shared uint least;

void write_dispatch(uint at, uint count) {
    arguments[at] = min(count, DISPATCH_X);
    arguments[at + 1u] = (count + DISPATCH_X - 1u) / DISPATCH_X;
    arguments[at + 2u] = 1u;
}

bool is_root(uint page) { return key_level(pages[page].key) == ROOT_LEVEL; }

uint page_rank(uint page, uint pairs) {
    Node node = nodes[pages[page].node];
    return refine_rank(min(node.own + node.below, 0x3fffffffu), pairs);
}

void main() {
    uint local = gl_LocalInvocationIndex;
    uint share = (counters.sorted + 255u) / 256u;
    uint begin = min(local * share, counters.sorted);
    uint end = min(begin + share, counters.sorted);
    for (uint i = local; i < RANKS; i += 256u) {
        ranks[i] = 0u;
    }
    if (local == 0u) {
        asked = 0u;
        roots = 0u;
    }
    barrier();
    for (uint i = begin; i < end; i++) {
        uint pairs = pair_cursors[2u * i] + pair_cursors[2u * i + 1u];
        atomicAdd(asked, pairs);
        if (is_root(i)) {
            atomicAdd(roots, pairs);
        } else {
            atomicAdd(ranks[page_rank(i, pairs)], pairs);
        }
    }
    barrier();
    // the least rank of which all pairs, with those of higher ranks, fit beside the roots
    if (local == 0u) {
        uint sum = roots;
        least = RANKS;
        while (least > 0u && sum + ranks[least - 1u] <= PAIR_CAPACITY) {
            least--;
            sum += ranks[least];
        }
    }
    barrier();
    uvec2 sum = uvec2(0u);
    for (uint i = begin; i < end; i++) {
        uvec2 count = uvec2(pair_cursors[2u * i], pair_cursors[2u * i + 1u]);
        bool fits = is_root(i) ? roots <= PAIR_CAPACITY : page_rank(i, count.x + count.y) >= least;
        pages[i].admitted = fits ? 1u : 0u;
        sum += fits ? count : uvec2(0u);
    }
    sums[local] = sum;
    barrier();
    for (uint step = 1u; step < 256u; step *= 2u) {
        uvec2 before = local >= step ? sums[local - step] : uvec2(0u);
        barrier();
        sums[local] += before;
        barrier();
    }
    sum = sums[local] - sum;
    for (uint i = begin; i < end; i++) {
        if (pages[i].admitted != 0u) {
            uvec2 count = uvec2(pair_cursors[2u * i], pair_cursors[2u * i + 1u]);
            pair_cursors[2u * i] = sum.x;
            pair_cursors[2u * i + 1u] = sum.y;
            sum += count;
            atomicAdd(counters.admitted, 1u);
            atomicAdd(counters.resident[key_level(pages[i].key)], 1u);
        }
    }
    if (local == 255u) {
        counters.pairs_asked = asked;
        counters.pairs_opaque = sums[255].x;
        counters.pairs_masked = sums[255].y;
        arguments[argument] = 3u;
        arguments[argument + 1u] = counters.sorted;
        arguments[argument + 2u] = 0u;
        arguments[argument + 3u] = 0u;
        write_dispatch(argument + 4u, sums[255].x);
        write_dispatch(argument + 7u, sums[255].y);
    }
}
