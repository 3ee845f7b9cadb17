#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/light.glsl"

// Writes the (cluster, page) pairs of the admitted pages that the engine draws, page by page.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint PAGE_TEXELS = 128u;
layout(constant_id = 1) const uint GUTTER = 0u;
layout(constant_id = 2) const uint TABLE_SIZE = 1024u;
layout(constant_id = 3) const uint FACE_CAPACITY = 6u;
layout(constant_id = 4) const uint PAIR_CAPACITY = 1024u;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(std430, binding = 1) readonly buffer CountersBlock { Counters counters; };
layout(std430, binding = 2) readonly buffer Nodes { Node nodes[]; };
layout(std430, binding = 3) readonly buffer Items { Item items[]; };
layout(std430, binding = 4) readonly buffer Instances { Instance instances[]; };
layout(std430, binding = 5) readonly buffer Meshes { MeshBounds meshes[]; };
layout(std430, binding = 6) readonly buffer Clusters { Cluster clusters[]; };
layout(std430, binding = 7) readonly buffer Pages { Page pages[]; };
layout(std430, binding = 8) buffer PairCursors { uint pair_cursors[]; };
layout(std430, binding = 9) writeonly buffer Pairs { Pair pairs[]; };
layout(std430, binding = 10) readonly buffer TableKeys { uint table_keys[]; };
layout(std430, binding = 11) readonly buffer Lights { Light lights[]; };
layout(std430, binding = 12) readonly buffer Roots { uint roots[]; };
layout(std430, binding = 13) readonly buffer ActiveFaces { uint active_faces[]; };
layout(push_constant) uniform Push { uint layer; };

#include "shared/anchor.glsl"

uint instance, cluster, kind;

uint item_count() { return counters.items[layer]; }
bool enter(Node node) { return (node.marks & (MARK_DRAWN << layer)) != 0u; }
bool visit(uint index, Node node) {
    uint page = node.page - 1u;
    if (node.page != 0u && (pages[page].draws >> layer & 1u) != 0u && pages[page].admitted != 0u) {
        uint at = atomicAdd(pair_cursors[PAIR_KINDS * (2u * page + layer) + kind], 1u);
        vec3 anchor = page_anchor(lights[key_face(pages[page].key) / FACES], pages[page], instances[instance]);
        pairs[kind * PAIR_CAPACITY + at] = Pair(2u * page + layer, instance, cluster, float[3](anchor.x, anchor.y, anchor.z));
    }
    return false;
}

#include "shared/items.glsl"
#include "shared/table.glsl"
#include "shared/walk.glsl"

void main() {
    if (!item_cluster(instance, cluster)) {
        return;
    }
    kind = pair_kind(instances[instance]);
    // cull_host lists the others
    if (kind != PAIR_HOST) {
        walk(1u, cluster_box(instances[instance], clusters[cluster]));
    }
}
