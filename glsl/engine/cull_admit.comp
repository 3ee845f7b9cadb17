#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/light.glsl"
#include "shared/refine.glsl"

// Admits pages while their pairs fit the budget, gives each its ranges of those that the engine draws, and writes the
// arguments of what follows. Roots first, directional lights before others: they answer for everything. Then those that gain the most pixels for
// their cost, which is linear in layers and pairs (Fernando 2002, sec. 2.4); within the rank at which the budget ends, as
// many as fit in their order, so that a page whose pairs fit alone is never put off for ever. One workgroup.
layout(local_size_x = 256) in;
layout(constant_id = 0) const uint PAIR_CAPACITY = 1024u;
layout(constant_id = 1) const uint DISPATCH_X = 32768u;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(std430, binding = 1) buffer CountersBlock { Counters counters; };
layout(std430, binding = 2) buffer Pages { Page pages[]; };
layout(std430, binding = 3) buffer PairCursors { uint pair_cursors[]; };  // PAIR_KINDS of each layer of each page
layout(std430, binding = 4) writeonly buffer Arguments { uint arguments[]; };
layout(std430, binding = 5) readonly buffer Nodes { Node nodes[]; };
layout(std430, binding = 6) readonly buffer Lights { Light lights[]; };
layout(push_constant) uniform Push { uint argument; };  // first of 3 + 3 words: triangles of opaque and masked pairs

shared uvec2 sums[256];
shared uint ranks[RANKS];  // pairs of the pages of each rank
shared uint asked;
shared uint least;         // least rank of which all pages are admitted

void write_dispatch(uint at, uint count) {
    arguments[at] = min(count, DISPATCH_X);
    arguments[at + 1u] = (count + DISPATCH_X - 1u) / DISPATCH_X;
    arguments[at + 2u] = 1u;
}

// Pairs of a page, for each kind.
uvec3 pairs_of(uint page) {
    uint at = 2u * PAIR_KINDS * page;
    uvec3 count = uvec3(0u);
    for (uint kind = 0u; kind < PAIR_KINDS; kind++) {
        count[kind] = pair_cursors[at + kind] + pair_cursors[at + PAIR_KINDS + kind];
    }
    return count;
}

uint all_pairs(uint page) {
    uvec3 count = pairs_of(page);
    return count.x + count.y + count.z;
}

// The upper half of the ranks is for roots.
uint page_rank(uint page, uint pairs) {
    uint draws = pages[page].draws;
    if (draws == 0u) {
        return RANKS - 1u;
    }
    Node node = nodes[pages[page].node];
    uvec2 key = pages[page].key;
    uint root = key_level(key) == ROOT_LEVEL ? RANKS / 2u : 0u;
    if (root != 0u && lights[key_face(key) / FACES].kind.x == LIGHT_DIRECTIONAL) {
        return RANKS - 1u;
    }
    uint pixels = min(node.own, 0x1fffffffu) + min(node.below, 0x1fffffffu);
    return refine_rank(pixels, int(pairs + frame.cache.w * ((draws & 1u) + (draws >> 1)))) / 2u + root;
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
    }
    barrier();
    for (uint i = begin; i < end; i++) {
        uint pairs = all_pairs(i);
        atomicAdd(asked, pairs);
        atomicAdd(ranks[page_rank(i, pairs)], pairs);
        pages[i].admitted = 0u;
    }
    barrier();
    if (local == 0u) {
        uint sum = 0u;
        least = RANKS;
        while (least > 0u && sum + ranks[least - 1u] <= PAIR_CAPACITY) {
            least--;
            sum += ranks[least];
        }
        for (uint i = 0u; least > 0u && i < counters.sorted; i++) {
            uint pairs = all_pairs(i);
            if (page_rank(i, pairs) + 1u == least && sum + pairs <= PAIR_CAPACITY) {
                pages[i].admitted = 1u;
                sum += pairs;
            }
        }
    }
    barrier();
    uvec2 sum = uvec2(0u);
    for (uint i = begin; i < end; i++) {
        bool fits = pages[i].admitted != 0u || page_rank(i, all_pairs(i)) >= least;
        pages[i].admitted = fits ? 1u : 0u;
        sum += fits ? pairs_of(i).xy : uvec2(0u);
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
            for (uint layer = 0u; layer < 2u; layer++) {
                uint at = PAIR_KINDS * (2u * i + layer);
                uvec2 count = uvec2(pair_cursors[at + PAIR_OPAQUE], pair_cursors[at + PAIR_MASKED]);
                pair_cursors[at + PAIR_OPAQUE] = sum.x;
                pair_cursors[at + PAIR_MASKED] = sum.y;
                sum += count;
            }
        }
    }
    if (local == 255u) {
        counters.pairs_asked = asked;
        counters.pairs_opaque = sums[255].x;
        counters.pairs_masked = sums[255].y;
        write_dispatch(argument, sums[255].x);
        write_dispatch(argument + 3u, sums[255].y);
    }
}
