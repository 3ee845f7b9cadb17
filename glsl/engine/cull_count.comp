#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/light.glsl"

// Counts the (cluster, page) pairs of every page that is drawn.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint PAGE_TEXELS = 128u;
layout(constant_id = 1) const uint GUTTER = 0u;
layout(constant_id = 2) const uint TABLE_SIZE = 1024u;
layout(constant_id = 3) const uint FACE_CAPACITY = 6u;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(std430, binding = 1) readonly buffer CountersBlock { Counters counters; };
layout(std430, binding = 2) readonly buffer Nodes { Node nodes[]; };
layout(std430, binding = 3) readonly buffer Items { Item items[]; };
layout(std430, binding = 4) readonly buffer Instances { Instance instances[]; };
layout(std430, binding = 5) readonly buffer Meshes { MeshBounds meshes[]; };
layout(std430, binding = 6) readonly buffer Clusters { Cluster clusters[]; };
layout(std430, binding = 7) readonly buffer Pages { Page pages[]; };
layout(std430, binding = 8) buffer PairCounts { uint pair_counts[]; };  // PAIR_KINDS of each layer of each page
layout(std430, binding = 9) readonly buffer TableKeys { uint table_keys[]; };
layout(std430, binding = 10) readonly buffer Lights { Light lights[]; };
layout(std430, binding = 11) readonly buffer Roots { uint roots[]; };
layout(std430, binding = 12) readonly buffer ActiveFaces { uint active_faces[]; };
layout(push_constant) uniform Push { uint layer; };

uint instance, cluster, kind;

uint item_count() { return counters.items[layer]; }
bool enter(Node node) { return (node.marks & (MARK_DRAWN << layer)) != 0u; }
bool visit(uint index, Node node) {
    if (node.page != 0u && (pages[node.page - 1u].draws >> layer & 1u) != 0u) {
        atomicAdd(pair_counts[PAIR_KINDS * (2u * (node.page - 1u) + layer) + kind], 1u);
    }
    return false;
}

#include "shared/items.glsl"
#include "shared/table.glsl"
#include "shared/walk.glsl"

void main() {
    if (item_cluster(instance, cluster)) {
        kind = pair_kind(instances[instance]);
        walk(1u, cluster_box(instances[instance], clusters[cluster]));
    }
}
