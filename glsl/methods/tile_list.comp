#version 460
#extension GL_GOOGLE_include_directive : require
#include "methods/tile.glsl"

// Lists the tiles that are drawn. One workgroup.
layout(local_size_x = 256) in;
layout(std430, binding = 0) readonly buffer Drawn { uint drawn[]; };
layout(std430, binding = 1) writeonly buffer List { uint list[]; };
layout(std430, binding = 2) buffer Counts { TileCounts counts; };
layout(push_constant) uniform Push { uint instance_count; };

shared uint listed;

void main() {
    uint local = gl_LocalInvocationIndex;
    if (local == 0u) {
        listed = 0u;
    }
    barrier();
    for (uint tile = local; tile < uint(drawn.length()); tile += 256u) {
        if (drawn[tile] != 0u) {
            list[atomicAdd(listed, 1u)] = tile;
        }
    }
    barrier();
    if (local == 0u) {
        counts.groups = uint[4]((instance_count + 63u) / 64u, listed, 1u, 0u);
        counts.items = 0u;
        counts.opaque = 0u;
        counts.masked = 0u;
    }
}
