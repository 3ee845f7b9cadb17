#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/structs.glsl"
#include "shared/bvh.glsl"

// The trees of the listed clusters. A cluster's triangles are halved again and again across the longest axis of their
// centres; one thread a triangle, which knows its place and counts who comes before it.
layout(local_size_x = 128) in;
layout(constant_id = 11) const uint POSITION_STRIDE = 3u;
layout(constant_id = 12) const uint POSITION_OFFSET = 0u;
layout(constant_id = 13) const uint POSITION_FORMAT = 0u;
layout(std430, binding = 0) readonly buffer List { uint list[]; };
layout(std430, binding = 1) readonly buffer Clusters { Cluster clusters[]; };
layout(std430, binding = 2) readonly buffer Indices { uint indices[]; };
layout(std430, binding = 3) readonly buffer Positions { uint positions[]; };
layout(std430, binding = 4) writeonly buffer Tree { uvec4 tree[]; };

shared uint keys[128];        // by place
shared uint segment_low[96];  // bounds of centres: three axes a segment
shared uint segment_high[96];
shared uint low_of[128];      // boxes
shared uint high_of[128];

const uint EMPTY_LOW = 0x3fffffffu;
const uint EMPTY_HIGH = 0u;

uint pack(uvec3 v) { return v.x | v.y << 10 | v.z << 20; }
uvec3 unpack(uint v) { return uvec3(v, v >> 10, v >> 20) & 1023u; }

// Sorts the triangles of every segment of `size` places, at least 4, along the longest axis of their centres and returns the
// new place of this thread's one. Places from `count` on are empty; threads without a triangle take part all the same.
uint halve(uint place, uvec3 centre, uint size, uint count) {
    bool present = gl_LocalInvocationIndex < count;
    uint segment = 3u * (place / size);
    if (gl_LocalInvocationIndex < 96u) {
        segment_low[gl_LocalInvocationIndex] = 1023u;
        segment_high[gl_LocalInvocationIndex] = 0u;
    }
    barrier();
    for (uint axis = 0u; present && axis < 3u; axis++) {
        atomicMin(segment_low[segment + axis], centre[axis]);
        atomicMax(segment_high[segment + axis], centre[axis]);
    }
    barrier();
    uvec3 span;
    for (uint axis = 0u; axis < 3u; axis++) {
        span[axis] = segment_high[segment + axis] - segment_low[segment + axis];
    }
    uint along = span.x >= span.y && span.x >= span.z ? centre.x : span.y >= span.z ? centre.y : centre.z;
    // those with the same centre keep their order
    uint key = along << 7 | place;
    if (present) {
        keys[place] = key;
    }
    barrier();
    uint begin = place & ~(size - 1u);
    uint rank = 0u;
    for (uint i = begin; present && i < min(begin + size, count); i++) {
        rank += keys[i] < key ? 1u : 0u;
    }
    return present ? begin + rank : place;
}

#include "shared/position.glsl"

void build(Cluster cluster) {
    uint local = gl_LocalInvocationIndex;
    uint n = min(cluster.triangle_count, 128u);
    vec3 center = vec3(cluster.center[0], cluster.center[1], cluster.center[2]);
    vec3 extent = vec3(cluster.extent[0], cluster.extent[1], cluster.extent[2]);
    extent = max(extent, vec3(1e-6 * max(max(extent.x, extent.y), extent.z) + 1e-30));
    uvec3 vertices = uvec3(0u);
    vec3 low = vec3(0.0), high = vec3(0.0);
    uvec3 centre = uvec3(0u);
    if (local < n) {
        uint first = cluster.first_index + 3u * local;
        vertices = uvec3(indices[first], indices[first + 1u], indices[first + 2u]);
        vec3 a = position(vertices.x), b = position(vertices.y), c = position(vertices.z);
        low = 0.5 * CLUSTER_STEPS * ((min(min(a, b), c) - center) / extent + 1.0);
        high = 0.5 * CLUSTER_STEPS * ((max(max(a, b), c) - center) / extent + 1.0);
        // steps so coarse that the halves of a quad have the same centre: apart they would make worse leaves
        vec3 middle = 0.5 * (low + high) * extent / max(max(extent.x, extent.y), extent.z);
        centre = uvec3(clamp(middle, 0.0, CLUSTER_STEPS));
    }
    uint place = local;
    for (uint size = 128u; size > LEAF; size /= 2u) {
        if (size < 2u * n) {
            place = halve(place, centre, size, n);
        }
    }
    barrier();
    if (local < n) {
        low_of[place] = pack(uvec3(clamp(floor(low - 0.01), 0.0, CLUSTER_STEPS)));
        high_of[place] = pack(uvec3(clamp(ceil(high + 0.01), 0.0, CLUSTER_STEPS)));
        tree[TRIANGLES + cluster.first_index / 3u + place] = uvec4(vertices, 0u);
    } else {
        low_of[local] = EMPTY_LOW;
        high_of[local] = EMPTY_HIGH;
    }
    // leaves, then nodes: each level's boxes replace those of the level below
    uint root = NODES + 2u * (cluster.first_index / 9u);
    uint levels = cluster_levels(n);
    uint width = LEAF;
    uint count = 128u / LEAF;
    for (uint step = 0u; step <= levels; step++) {
        barrier();
        uvec4 lows = uvec4(EMPTY_LOW), highs = uvec4(EMPTY_HIGH);
        uvec3 l = uvec3(1023u), h = uvec3(0u);
        if (local < count) {
            for (uint c = 0u; c < width; c++) {
                lows[c] = low_of[local * width + c];
                highs[c] = high_of[local * width + c];
                l = min(l, unpack(lows[c]));
                h = max(h, unpack(highs[c]));
            }
            if (step > 0u && local << (2u * step) < (n + LEAF - 1u) / LEAF) {
                uint node = root + 2u * (level_begin(levels - step) + local);
                tree[node] = lows;
                tree[node + 1u] = highs;
            }
        }
        barrier();
        low_of[local] = local < count ? pack(l) : EMPTY_LOW;
        high_of[local] = local < count ? pack(h) : EMPTY_HIGH;
        width = 4u;
        count /= 4u;
    }
}

void main() {
    for (uint i = gl_WorkGroupID.x; i < list[0]; i += gl_NumWorkGroups.x) {
        build(clusters[list[1u + i]]);
        barrier();
    }
}
