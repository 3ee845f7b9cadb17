#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/light.glsl"

// Lists the pages of every caster that the host draws, one after another, and completes the host's draw command of it. Such a
// caster is one cluster, and lies in one layer: one thread does all of it.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint PAGE_TEXELS = 128u;
layout(constant_id = 1) const uint GUTTER = 0u;
layout(constant_id = 2) const uint TABLE_SIZE = 1024u;
layout(constant_id = 3) const uint FACE_CAPACITY = 6u;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(std430, binding = 1) buffer CountersBlock { Counters counters; };
layout(std430, binding = 2) readonly buffer Nodes { Node nodes[]; };
layout(std430, binding = 3) readonly buffer Items { Item items[]; };
layout(std430, binding = 4) readonly buffer Instances { Instance instances[]; };
layout(std430, binding = 5) readonly buffer Meshes { MeshBounds meshes[]; };
layout(std430, binding = 6) readonly buffer Clusters { Cluster clusters[]; };
layout(std430, binding = 7) readonly buffer Pages { Page pages[]; };
layout(std430, binding = 8) writeonly buffer Pairs { Pair pairs[]; };
layout(std430, binding = 9) readonly buffer TableKeys { uint table_keys[]; };
layout(std430, binding = 10) readonly buffer Lights { Light lights[]; };
layout(std430, binding = 11) readonly buffer Roots { uint roots[]; };
layout(std430, binding = 12) readonly buffer ActiveFaces { uint active_faces[]; };
layout(std430, binding = 13) buffer HostDraws { DrawCommand host_draws[]; };
layout(push_constant) uniform Push { uint layer; };

#include "shared/anchor.glsl"

uint instance, cluster;
bool writes;
uint first, count;

uint item_count() { return counters.items[layer]; }
bool enter(Node node) { return (node.marks & (MARK_DRAWN << layer)) != 0u; }
bool visit(uint index, Node node) {
    uint page = node.page - 1u;
    // pages that got no layer are not drawn
    if (node.page != 0u && (pages[page].draws >> layer & 1u) != 0u && pages[page].admitted == 1u) {
        if (writes) {
            vec3 anchor = page_anchor(lights[key_face(pages[page].key) / FACES], pages[page], instances[instance]);
            pairs[first + count] = Pair(2u * page + layer, instance, cluster, float[3](anchor.x, anchor.y, anchor.z));
        }
        count++;
    }
    return false;
}

#include "shared/items.glsl"
#include "shared/table.glsl"
#include "shared/walk.glsl"

void main() {
    if (!item_cluster(instance, cluster) || (instances[instance].flags & HOST_DRAWN) == 0u) {
        return;
    }
    // the same walk counts, then writes; all that is admitted fits
    for (uint i = 0u; i < 2u; i++) {
        writes = i == 1u;
        count = 0u;
        walk(1u, cluster_box(instances[instance], clusters[cluster]));
        first = writes ? first : atomicAdd(counters.pairs_host, count);
    }
    host_draws[instance].instance_count = count;
    host_draws[instance].first_instance = first;
}
