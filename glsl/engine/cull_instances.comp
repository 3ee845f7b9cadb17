#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/light.glsl"

// Finds the instances of the cached layer that touch a page which is drawn, and lists their clusters.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint PAGE_TEXELS = 128u;
layout(constant_id = 1) const uint GUTTER = 0u;
layout(constant_id = 2) const uint TABLE_SIZE = 1024u;
layout(constant_id = 3) const uint FACE_CAPACITY = 6u;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(std430, binding = 1) buffer CountersBlock { Counters counters; };
layout(std430, binding = 2) readonly buffer Nodes { Node nodes[]; };
layout(std430, binding = 3) readonly buffer Instances { Instance instances[]; };
layout(std430, binding = 4) readonly buffer Meshes { MeshBounds meshes[]; };
layout(std430, binding = 5) readonly buffer TrackedInstances { Tracked tracked[]; };
layout(std430, binding = 6) readonly buffer Pages { Page pages[]; };
layout(std430, binding = 7) writeonly buffer Items { Item items[]; };
layout(std430, binding = 8) readonly buffer TableKeys { uint table_keys[]; };
layout(std430, binding = 9) readonly buffer Lights { Light lights[]; };
layout(std430, binding = 10) readonly buffer Roots { uint roots[]; };
layout(std430, binding = 11) readonly buffer ActiveFaces { uint active_faces[]; };
layout(push_constant) uniform Push { uint instance_count; };

bool found = false;

bool enter(Node node) { return (node.marks & MARK_DRAWN) != 0u; }
bool visit(uint index, Node node) {
    found = node.page != 0u && (pages[node.page - 1u].draws & 1u) != 0u;
    return found;
}

#include "shared/table.glsl"
#include "shared/walk.glsl"

void main() {
    uint index = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationIndex;
    // nothing to draw, or only pages whose layer is right
    if (index >= instance_count || counters.hits == counters.sorted || tracked[index].state != CASTER_STATIC) {
        return;
    }
    walk(1u, mesh_box(instances[index], meshes[instances[index].mesh]));
    if (found) {
        MeshBounds mesh = meshes[instances[index].mesh];
        uint runs = (mesh.cluster_count + RUN - 1u) / RUN;
        uint first = atomicAdd(counters.items[0], runs);
        for (uint i = 0u; i < runs && first + i < uint(items.length()); i++) {
            items[first + i] = Item(index, mesh.first_cluster + RUN * i);
        }
    }
}
