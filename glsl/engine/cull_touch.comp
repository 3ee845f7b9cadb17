#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/light.glsl"

// Marks every page of the quadtree that a moving cluster touches: such pages need a second layer.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint PAGE_TEXELS = 128u;
layout(constant_id = 1) const uint GUTTER = 0u;
layout(constant_id = 2) const uint TABLE_SIZE = 1024u;
layout(constant_id = 3) const uint FACE_CAPACITY = 6u;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(std430, binding = 1) readonly buffer CountersBlock { Counters counters; };
layout(std430, binding = 2) buffer Nodes { Node nodes[]; };
layout(std430, binding = 3) readonly buffer Items { Item items[]; };
layout(std430, binding = 4) readonly buffer Instances { Instance instances[]; };
layout(std430, binding = 5) readonly buffer Meshes { MeshBounds meshes[]; };
layout(std430, binding = 6) readonly buffer Clusters { Cluster clusters[]; };
layout(std430, binding = 7) readonly buffer TableKeys { uint table_keys[]; };
layout(std430, binding = 8) readonly buffer Lights { Light lights[]; };
layout(std430, binding = 9) readonly buffer Roots { uint roots[]; };
layout(std430, binding = 10) readonly buffer ActiveFaces { uint active_faces[]; };

uint item_count() { return counters.items[1]; }
bool enter(Node node) { return true; }
bool visit(uint index, Node node) {
    if ((node.marks & MARK_DYNAMIC) == 0u) {
        atomicOr(nodes[index].marks, MARK_DYNAMIC);
    }
    return false;
}

#include "shared/items.glsl"
#include "shared/table.glsl"
#include "shared/walk.glsl"

void main() {
    uint instance, cluster;
    if (item_cluster(instance, cluster)) {
        walk(0u, cluster_box(instances[instance], clusters[cluster]));
    }
}
