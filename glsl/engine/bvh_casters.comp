#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/structs.glsl"
#include "shared/bvh.glsl"

// Places the sorted casters: their records and the last level of top nodes. One thread a caster.
layout(local_size_x = 64) in;
layout(constant_id = 11) const uint INSTANCE_COUNT = 1u;
layout(std430, binding = 0) readonly buffer Instances { Instance instances[]; };
layout(std430, binding = 1) readonly buffer Meshes { MeshBounds meshes[]; };
layout(std430, binding = 2) readonly buffer Clusters { Cluster clusters[]; };
layout(std430, binding = 3) readonly buffer Firsts { uint firsts[]; };
layout(std430, binding = 4) readonly buffer Values { uint values[]; };
layout(std430, binding = 5) writeonly buffer Tree { uvec4 tree[]; };

#include "shared/bvh_caster.glsl"

shared uvec3 boxes[64];

// To steps of the cluster's bounds from world space: the inverse of the instance's matrix, scaled.
Caster caster_of(uint index, Instance instance, Cluster cluster) {
    vec3 x = instance.rows[0].xyz, y = instance.rows[1].xyz, z = instance.rows[2].xyz;
    mat3 adjugate = mat3(cross(y, z), cross(z, x), cross(x, y));  // columns
    float determinant = dot(x, adjugate[0]);
    vec3 middle = vec3(cluster.center[0], cluster.center[1], cluster.center[2]);
    vec3 extent = vec3(cluster.extent[0], cluster.extent[1], cluster.extent[2]);
    extent = max(extent, vec3(1e-6 * max(max(extent.x, extent.y), extent.z) + 1e-30));
    Caster caster;
    caster.instance = index;
    caster.first = cluster.first_index / 3u;
    caster.count = min(cluster.triangle_count, 128u) | (determinant < 0.0 ? MIRRORED : 0u) | ((instance.flags & ALPHA_TESTED) != 0u ? MASKED : 0u);
    vec3 translation = vec3(instance.rows[0].w, instance.rows[1].w, instance.rows[2].w);
    // how far the matrix is from one that shrinks no direction more than others
    float condition = length(x) * length(adjugate[0]) + length(y) * length(adjugate[1]) + length(z) * length(adjugate[2]);
    float reach = 0.0;
    bool squashed = !(abs(determinant) > 1e-6 * condition);
    vec3 low = vec3(LOW_X, LOW_Y, LOW_Z);
    vec3 farthest = max(abs(low), abs(low + TOP_STEPS / vec3(STEPS_X, STEPS_Y, STEPS_Z)));
    for (int i = 0; i < 3; i++) {
        vec3 row = vec3(adjugate[0][i], adjugate[1][i], adjugate[2][i]) / determinant * (0.5 * CLUSTER_STEPS / extent[i]);
        float shift = 0.5 * CLUSTER_STEPS * (1.0 - middle[i] / extent[i]) - dot(row, translation);
        caster.rows[i] = squashed ? vec4(0.0) : vec4(row, shift);
        reach = max(reach, dot(abs(row), farthest + abs(translation)) + 0.5 * CLUSTER_STEPS * abs(middle[i]) / extent[i]);
    }
    caster.margin = squashed ? 0.0 : 0.01 + 1e-6 * reach * (condition / abs(determinant));
    return caster;
}

void main() {
    uint local = gl_LocalInvocationIndex;
    uint at = gl_GlobalInvocationID.x;
    uint index, c;
    uvec3 box = uvec3(TOP_EMPTY);
    if (at < CASTER_COUNT && slot_caster(values[at], index, c)) {
        Instance instance = instances[index];
        Cluster cluster = clusters[c];
        vec3 center, extent;
        placed_bounds(instance, cluster, center, extent);
        // the margin holds the rounding of bounds and rays: a few units in the last place of the scene's size
        uvec3 low = uvec3(clamp(floor(top_steps(center - extent) - 0.25), 0.0, TOP_STEPS));
        uvec3 high = uvec3(clamp(ceil(top_steps(center + extent) + 0.25), 0.0, TOP_STEPS));
        box = low | high << 16;
        Caster caster = caster_of(index, instance, cluster);
        for (uint i = 0u; i < 3u; i++) {
            tree[CASTERS + 4u * at + i] = floatBitsToUint(caster.rows[i]);
        }
        tree[CASTERS + 4u * at + 3u] = uvec4(caster.instance, caster.first, caster.count, floatBitsToUint(caster.margin));
    }
    boxes[local] = box;
    barrier();
    if (local < 16u && gl_WorkGroupID.x * 64u + 4u * local < CASTER_COUNT) {
        uint node = level_begin(TOP_LEVELS - 1u) + gl_WorkGroupID.x * 16u + local;
        for (uint axis = 0u; axis < 3u; axis++) {
            uint i = 4u * local;
            tree[3u * node + axis] = uvec4(boxes[i][axis], boxes[i + 1u][axis], boxes[i + 2u][axis], boxes[i + 3u][axis]);
        }
    }
}
