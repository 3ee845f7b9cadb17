#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/bvh.glsl"

// The top nodes of a level from those of the next: one thread a node.
layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Tree { uvec4 tree[]; };
layout(push_constant) uniform Push { uint level; };

uint least(uvec4 v) { return min(min(v.x, v.y), min(v.z, v.w)); }
uint most(uvec4 v) { return max(max(v.x, v.y), max(v.z, v.w)); }

void main() {
    uint index = gl_GlobalInvocationID.x;
    uint below = TOP_LEVELS - 1u - level;  // levels below this one
    if (index > (CASTER_COUNT - 1u) >> (2u * (below + 1u))) {
        return;
    }
    uint children = ((CASTER_COUNT - 1u) >> (2u * below)) + 1u;
    uint node = 3u * (level_begin(level) + index);
    uint first = level_begin(level + 1u);
    for (uint axis = 0u; axis < 3u; axis++) {
        uvec4 boxes = uvec4(TOP_EMPTY);
        for (uint c = 4u * index; c < min(4u * index + 4u, children); c++) {
            uvec4 child = tree[3u * (first + c) + axis];
            boxes[c & 3u] = least(child & 0xffffu) | most(child >> 16) << 16;
        }
        tree[node + axis] = boxes;
    }
}
