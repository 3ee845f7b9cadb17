#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/structs.glsl"
#include "methods/fit.glsl"

// A draw for each cluster that touches a tile which is drawn. RUN threads share an item; all workgroups share the list.
layout(local_size_x = 64) in;
layout(constant_id = 0) const float SIDE = 128.0;
layout(constant_id = 2) const uint PAIR_CAPACITY = 1024u;  // of opaque pairs; as many masked ones come after them
#define LIGHT_BINDING 0
#include "methods/light.glsl"
#include "methods/tile.glsl"
#include "methods/tile_bounds.glsl"
layout(std430, binding = 1) readonly buffer Fits { Fit fits[]; };
layout(std430, binding = 2) readonly buffer Instances { Instance instances[]; };
layout(std430, binding = 3) readonly buffer Meshes { MeshBounds meshes[]; };
layout(std430, binding = 4) readonly buffer Clusters { Cluster clusters[]; };
layout(std430, binding = 5) buffer Counts { TileCounts counts; };
layout(std430, binding = 6) readonly buffer Items { TileItem items[]; };
layout(std430, binding = 7) writeonly buffer Pairs { TilePair pairs[]; };
layout(std430, binding = 8) writeonly buffer Commands { DrawCommand commands[]; };

void draw(TileItem item, Cluster cluster, bool masked) {
    uint at = masked ? atomicAdd(counts.masked, 1u) : atomicAdd(counts.opaque, 1u);
    if (at >= PAIR_CAPACITY) {
        atomicAdd(counts.dropped, 1u);
        return;
    }
    at += masked ? PAIR_CAPACITY : 0u;
    pairs[at] = TilePair(item.tile, item.instance);
    commands[at] = DrawCommand(3u * cluster.triangle_count, 1u, cluster.first_index, 0, at);
}

void main() {
    uint count = RUN * min(counts.items, uint(items.length()));
    uint threads = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
    for (uint thread = gl_GlobalInvocationID.x; thread < count; thread += threads) {
        TileItem item = items[thread / RUN];
        Instance instance = instances[item.instance];
        MeshBounds mesh = meshes[instance.mesh];
        uint index = item.first_cluster + thread % RUN;
        if (index >= mesh.first_cluster + mesh.cluster_count) {
            continue;
        }
        Cluster cluster = clusters[index];
        vec3 center = vec3(cluster.center[0], cluster.center[1], cluster.center[2]);
        vec3 extent = vec3(cluster.extent[0], cluster.extent[1], cluster.extent[2]);
        if (touches(fits[item.tile], instance, center, extent, SIDE)) {
            draw(item, cluster, (instance.flags & ALPHA_TESTED) != 0u);
        }
    }
}
