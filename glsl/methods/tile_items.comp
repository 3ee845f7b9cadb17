#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/structs.glsl"
#include "methods/fit.glsl"

// Lists the clusters of each instance that touches a tile which is drawn, in runs.
layout(local_size_x = 64) in;
layout(constant_id = 0) const float SIDE = 128.0;
#define LIGHT_BINDING 0
#include "methods/light.glsl"
#include "methods/tile.glsl"
#include "methods/tile_bounds.glsl"
layout(std430, binding = 1) readonly buffer Fits { Fit fits[]; };
layout(std430, binding = 2) readonly buffer Instances { Instance instances[]; };
layout(std430, binding = 3) readonly buffer Meshes { MeshBounds meshes[]; };
layout(std430, binding = 4) readonly buffer List { uint list[]; };
layout(std430, binding = 5) buffer Counts { TileCounts counts; };
layout(std430, binding = 6) writeonly buffer Items { TileItem items[]; };
layout(push_constant) uniform Push { uint instance_count; };

void main() {
    uint index = gl_GlobalInvocationID.x, tile = list[gl_WorkGroupID.y];
    if (index >= instance_count || (instances[index].flags & 3u) == POLICY_NEVER) {
        return;
    }
    MeshBounds mesh = meshes[instances[index].mesh];
    vec3 center = vec3(mesh.center[0], mesh.center[1], mesh.center[2]);
    vec3 extent = vec3(mesh.extent[0], mesh.extent[1], mesh.extent[2]);
    if (!touches(fits[tile], instances[index], center, extent, SIDE)) {
        return;
    }
    uint runs = (mesh.cluster_count + RUN - 1u) / RUN;
    uint first = atomicAdd(counts.items, runs);
    uint kept = min(runs, uint(items.length()) - min(first, uint(items.length())));
    for (uint i = 0u; i < kept; i++) {
        items[first + i] = TileItem(tile, index, mesh.first_cluster + RUN * i);
    }
    if (kept < runs) {
        atomicAdd(counts.dropped, runs - kept);
    }
}
