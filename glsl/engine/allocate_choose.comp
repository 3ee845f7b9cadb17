#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/refine.glsl"

// Finds the least rank whose nodes, with all of higher rank, can be refined: within the layers of the atlas, then within
// the layers that may be drawn. One workgroup.
layout(local_size_x = 256) in;
layout(constant_id = 0) const int SLOTS = 1024;
layout(std430, binding = 0) buffer CountersBlock { Counters counters; };
layout(std430, binding = 1) readonly buffer Histogram { int histogram[]; };
layout(std430, binding = 2) readonly buffer Nodes { Node nodes[]; };
layout(push_constant) uniform Push {
    int draw_budget;
    uint draws;  // 0: decides about the atlas, 1: about drawing
};

shared int sums[256];
shared uint least;

// The least rank above 0 whose sum with all higher ranks is within the budget, and that sum of another histogram.
uint least_rank(uint first, int budget) {
    uint local = gl_LocalInvocationIndex;
    const uint share = RANKS / 256u;
    int sum = 0;
    for (uint i = 0u; i < share; i++) {
        sum += histogram[first + RANKS - 1u - (local * share + i)];
    }
    sums[local] = sum;
    if (local == 0u) {
        least = RANKS;
    }
    barrier();
    for (uint step = 1u; step < 256u; step *= 2u) {
        int before = local >= step ? sums[local - step] : 0;
        barrier();
        sums[local] += before;
        barrier();
    }
    sum = sums[local] - sum;
    for (uint i = 0u; i < share; i++) {
        uint rank = RANKS - 1u - (local * share + i);
        sum += histogram[first + rank];
        if (sum <= budget && rank > 0u) {
            atomicMin(least, rank);
        }
    }
    barrier();
    return least;
}

void main() {
    int layers = 0;
    int draw_count = 0;
    for (uint r = 0u; r < 4u; r++) {
        if (counters.roots[r] != 0u) {
            Node root = nodes[counters.roots[r] - 1u];
            layers += page_layers(root.marks);
            draw_count += page_draws(root.slot, root.marks);
        }
    }
    if (draws == 1u) {
        if (int(counters.draws_asked) > draw_budget) {
            uint rank = least_rank(2u * RANKS, draw_budget - draw_count);
            if (gl_LocalInvocationIndex == 0u) {
                counters.draw_threshold = rank;
                for (uint i = rank; i < RANKS; i++) {
                    draw_count += histogram[2u * RANKS + i];
                }
                counters.deferred = uint(max(int(counters.draws_asked) - draw_count, 0));
            }
        }
        return;
    }
    uint rank = least_rank(0u, SLOTS - layers);
    if (gl_LocalInvocationIndex == 0u) {
        counters.threshold = rank;
        for (uint i = rank; i < RANKS; i++) {
            draw_count += histogram[RANKS + i];
        }
        counters.draws_asked = uint(max(draw_count, 0));
    }
}
