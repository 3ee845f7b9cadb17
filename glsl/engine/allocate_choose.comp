#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/refine.glsl"

// Finds the least rank whose nodes, with all of higher rank, can be served: within the layers of the atlas, then within
// the layers that may be drawn; and how many nodes of the next rank, in their order, can still be. One workgroup.
layout(local_size_x = 256) in;
layout(constant_id = 0) const int SLOTS = 1024;
layout(std430, binding = 0) buffer CountersBlock { Counters counters; };
layout(std430, binding = 1) readonly buffer Histogram { int histogram[]; };
layout(push_constant) uniform Push {
    int draw_budget;
    uint step;  // 0: the atlas, 1: drawing by rank, 2: drawing by order
};

shared int sums[256];
shared uint best;

// Inclusive sum over the workgroup.
int scan(int value) {
    uint local = gl_LocalInvocationIndex;
    sums[local] = value;
    barrier();
    for (uint reach = 1u; reach < 256u; reach *= 2u) {
        int before = local >= reach ? sums[local - reach] : 0;
        barrier();
        sums[local] += before;
        barrier();
    }
    return sums[local];
}

// The least rank above 0 whose sum with all higher ranks is within the budget.
uint least_rank(uint first, int budget) {
    uint local = gl_LocalInvocationIndex;
    const uint share = ALL_RANKS / 256u;
    int own = 0;
    for (uint i = 0u; i < share; i++) {
        own += histogram[first + ALL_RANKS - 1u - (local * share + i)];
    }
    if (local == 0u) {
        best = ALL_RANKS;
    }
    int sum = scan(own) - own;
    for (uint i = 0u; i < share; i++) {
        uint rank = ALL_RANKS - 1u - (local * share + i);
        sum += histogram[first + rank];
        if (sum <= budget && rank > 0u) {
            atomicMin(best, rank);
        }
    }
    barrier();
    return best;
}

// The last place in the order before which the sum is within the budget.
uint last_order(uint first, int budget) {
    uint local = gl_LocalInvocationIndex;
    const uint share = ORDERS / 256u;
    int own = 0;
    for (uint i = 0u; i < share; i++) {
        own += histogram[first + local * share + i];
    }
    if (local == 0u) {
        best = 0u;
    }
    int sum = scan(own) - own;
    for (uint i = 0u; i < share; i++) {
        sum += histogram[first + local * share + i];
        if (sum <= budget) {
            atomicMax(best, local * share + i + 1u);
        }
    }
    barrier();
    return best;
}

int sum_of(uint first, uint from, uint to) {
    int sum = 0;
    for (uint i = from; i < to; i++) {
        sum += histogram[first + i];
    }
    return sum;
}

void main() {
    bool writes = gl_LocalInvocationIndex == 0u;
    if (step == 0u) {
        uint rank = least_rank(0u, SLOTS);
        if (writes) {
            counters.threshold = rank;
            counters.draws_asked = uint(max(sum_of(ALL_RANKS, rank, ALL_RANKS), 0));
        }
    } else if (int(counters.draws_asked) > draw_budget) {
        if (step == 1u) {
            uint rank = least_rank(2u * ALL_RANKS, draw_budget);
            if (writes) {
                counters.draw_threshold = rank;
                counters.deferred = uint(int(counters.draws_asked) - sum_of(2u * ALL_RANKS, rank, ALL_RANKS));
            }
        } else {
            int drawn = int(counters.draws_asked) - int(counters.deferred);
            uint order = last_order(3u * ALL_RANKS, draw_budget - drawn);
            if (writes) {
                counters.draw_order = order;
                counters.deferred -= uint(sum_of(3u * ALL_RANKS, 0u, order));
            }
        }
    }
}
