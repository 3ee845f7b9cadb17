#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/structs.glsl"
#include "shared/bvh.glsl"

// Numbers the casters: the slots of an instance's clusters follow those of the instances before it. Writes the sizes of
// all later dispatches, which are 0 where nothing changed.
layout(local_size_x = 256) in;
layout(constant_id = 11) const uint INSTANCE_COUNT = 1u;
layout(constant_id = 12) const uint BLOCK = 512u;
layout(std430, binding = 0) buffer CountersBlock { Counters counters; };  // of the sort; only `sorted` is used
layout(std430, binding = 1) readonly buffer Instances { Instance instances[]; };
layout(std430, binding = 2) readonly buffer Meshes { MeshBounds meshes[]; };
layout(std430, binding = 3) readonly buffer Changes { uint changes[]; };
layout(std430, binding = 4) writeonly buffer Firsts { uint firsts[]; };
layout(std430, binding = 5) writeonly buffer Arguments { uint arguments[]; };

shared uint sums[256];

uint casters_of(Instance instance) {
    return (instance.flags & 3u) == POLICY_NEVER ? 0u : meshes[instance.mesh].cluster_count;
}

void write_size(uint argument, uint groups) {
    arguments[3u * argument] = groups;
    arguments[3u * argument + 1u] = 1u;
    arguments[3u * argument + 2u] = 1u;
}

void main() {
    uint local = gl_LocalInvocationIndex;
    bool any = changes[0] != 0u;
    if (local == 0u) {
        uint on = any ? 1u : 0u;
        counters.sorted = on * CASTER_COUNT;
        write_size(0u, on * ((CASTER_COUNT + 63u) / 64u));
        write_size(1u, on * ((CASTER_COUNT + BLOCK - 1u) / BLOCK));
        write_size(2u, on);
        write_size(3u, 0u);
        for (uint level = 0u; level + 1u < TOP_LEVELS; level++) {
            uint nodes = ((CASTER_COUNT - 1u) >> (2u * (TOP_LEVELS - level))) + 1u;
            write_size(4u + level, on * ((nodes + 63u) / 64u));
        }
    }
    if (!any) {
        return;
    }
    uint share = (INSTANCE_COUNT + 255u) / 256u;
    uint begin = min(local * share, INSTANCE_COUNT);
    uint end = min(begin + share, INSTANCE_COUNT);
    uint sum = 0u;
    for (uint i = begin; i < end; i++) {
        sum += casters_of(instances[i]);
    }
    sums[local] = sum;
    barrier();
    for (uint step = 1u; step < 256u; step *= 2u) {
        uint before = local >= step ? sums[local - step] : 0u;
        barrier();
        sums[local] += before;
        barrier();
    }
    sum = sums[local] - sum;
    for (uint i = begin; i < end; i++) {
        firsts[i] = sum;
        sum += casters_of(instances[i]);
    }
    if (local == 255u) {
        firsts[INSTANCE_COUNT] = min(sum, CASTER_COUNT);
    }
}
