#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"

// Writes the (cluster, page) pairs of the admitted pages, page by page.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint PAGE_TEXELS = 128u;
layout(constant_id = 1) const uint GUTTER = 0u;
layout(constant_id = 2) const uint PAIR_CAPACITY = 1024u;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(std430, binding = 1) readonly buffer CountersBlock { Counters counters; };
layout(std430, binding = 2) readonly buffer Nodes { Node nodes[]; };
layout(std430, binding = 3) readonly buffer Casters { Caster casters[]; };
layout(std430, binding = 4) readonly buffer Clusters { Cluster clusters[]; };
layout(std430, binding = 5) readonly buffer Instances { Instance instances[]; };
layout(std430, binding = 6) buffer PairCursors { uint pair_cursors[]; };
layout(std430, binding = 7) readonly buffer Pages { Page pages[]; };
layout(std430, binding = 8) writeonly buffer Pairs { Pair pairs[]; };
layout(push_constant) uniform Push {
    uint caster_count;
    uint first_masked;
};

void visit(uint page, uint caster) {
    if (pages[page].admitted != 0u) {
        uint masked = caster >= first_masked ? 1u : 0u;
        uint index = atomicAdd(pair_cursors[2u * page + masked], 1u);
        pairs[masked * PAIR_CAPACITY + index] = Pair(page, caster);
    }
}

#include "shared/casters.glsl"

void main() {
    uint index = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationIndex;
    if (index < caster_count) {
        visit_pages(index);
    }
}
