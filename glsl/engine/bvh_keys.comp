#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/structs.glsl"
#include "shared/bvh.glsl"

// The key by which each caster is sorted, and the clusters whose own trees must be built again, each listed once.
layout(local_size_x = 64) in;
layout(constant_id = 11) const uint INSTANCE_COUNT = 1u;
layout(constant_id = 12) const uint CLUSTER_GROUPS = 1u;  // workgroups at most of bvh_clusters
layout(std430, binding = 0) readonly buffer Instances { Instance instances[]; };
layout(std430, binding = 1) readonly buffer Meshes { MeshBounds meshes[]; };
layout(std430, binding = 2) readonly buffer Clusters { Cluster clusters[]; };
layout(std430, binding = 3) readonly buffer Firsts { uint firsts[]; };
layout(std430, binding = 4) readonly buffer Changes { uint changes[]; };
layout(std430, binding = 5) writeonly buffer Keys { uvec2 keys[]; };
layout(std430, binding = 6) writeonly buffer Values { uint values[]; };
layout(std430, binding = 7) buffer Listed { uint listed[]; };        // a bit for each first triangle
layout(std430, binding = 8) buffer List { uint list[]; };            // number, clusters
layout(std430, binding = 9) buffer Arguments { uint arguments[]; };

#include "shared/bvh_caster.glsl"

// Every third bit from 10.
uint spread3(uint x) {
    x = (x | x << 16) & 0x030000ffu;
    x = (x | x << 8) & 0x0300f00fu;
    x = (x | x << 4) & 0x030c30c3u;
    return (x | x << 2) & 0x09249249u;
}

// Place of a cell on the Hilbert curve (Skilling 2004).
uint hilbert(uvec3 x) {
    for (uint q = 512u; q > 1u; q >>= 1) {
        uint p = q - 1u;
        for (int i = 0; i < 3; i++) {
            if ((x[i] & q) != 0u) {
                x.x ^= p;
            } else {
                uint t = (x.x ^ x[i]) & p;
                x.x ^= t;
                x[i] ^= t;
            }
        }
    }
    x.y ^= x.x;
    x.z ^= x.y;
    uint t = 0u;
    for (uint q = 512u; q > 1u; q >>= 1) {
        t ^= (x.z & q) != 0u ? q - 1u : 0u;
    }
    x ^= t;
    return spread3(x.x) << 2 | spread3(x.y) << 1 | spread3(x.z);
}

void main() {
    uint slot = gl_GlobalInvocationID.x;
    if (slot >= CASTER_COUNT) {
        return;
    }
    values[slot] = slot;
    uint index, c;
    if (!slot_caster(slot, index, c)) {
        keys[slot] = uvec2(0u, 0xffffffffu);
        return;
    }
    Cluster cluster = clusters[c];
    vec3 center, extent;
    placed_bounds(instances[index], cluster, center, extent);
    vec3 at = (center - vec3(LOW_X, LOW_Y, LOW_Z)) * min(min(STEPS_X, STEPS_Y), STEPS_Z);
    uvec3 cell = uvec3(clamp(at * (1.0 / 64.0), 0.0, 1023.0));
    keys[slot] = uvec2(0u, hilbert(cell));
    uint first = cluster.first_index / 3u;
    if ((changes[1u + index] & CHANGED_SHAPE) != 0u) {
        uint bit = 1u << (first & 31u);
        if ((atomicOr(listed[first >> 5], bit) & bit) == 0u) {
            uint at = atomicAdd(list[0], 1u);
            list[1u + at] = c;
            atomicMax(arguments[9], min(at + 1u, CLUSTER_GROUPS));
        }
    }
}
