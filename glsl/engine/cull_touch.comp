#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"

// Marks every page of the quadtree that a moving cluster touches: such pages need a second layer.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint PAGE_TEXELS = 128u;
layout(constant_id = 1) const uint GUTTER = 0u;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(std430, binding = 1) readonly buffer CountersBlock { Counters counters; };
layout(std430, binding = 2) buffer Nodes { Node nodes[]; };
layout(std430, binding = 3) readonly buffer Items { Item items[]; };
layout(std430, binding = 4) readonly buffer Instances { Instance instances[]; };
layout(std430, binding = 5) readonly buffer Meshes { MeshBounds meshes[]; };
layout(std430, binding = 6) readonly buffer Clusters { Cluster clusters[]; };

uint item_count() { return counters.items[1]; }
bool enter(Node node) { return true; }
bool visit(uint index, Node node) {
    if ((node.marks & MARK_DYNAMIC) == 0u) {
        atomicOr(nodes[index].marks, MARK_DYNAMIC);
    }
    return false;
}

#include "shared/items.glsl"
#include "shared/walk.glsl"

void main() {
    uint instance, cluster;
    if (item_cluster(instance, cluster)) {
        vec2 low, high;
        cluster_bounds(instances[instance], clusters[cluster], low, high);
        walk(low, high);
    }
}
