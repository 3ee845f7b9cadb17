#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/structs.glsl"
#define LIGHT_BINDING 0
#include "methods/light.glsl"
#define SILHOUETTE_BINDING 1
#define LIST_ACCESS
#include "methods/silhouette.glsl"

// Lists the edges that the light sees as silhouettes: all triangles that share one lie on the same side of it, so that it is a
// border of what they cover. That needs no orientation, and an edge of one triangle always is one. A workgroup takes a run.
layout(local_size_x = 64) in;

// Coordinates in which planes through an edge and the light are lines: (x, y, z) for a light with a position, else (x, y, 1).
vec3 seen(Instance instance, uint vertex) {
    vec3 ls = light_space(0u, world_position(instance, vertex) - light.eye.xyz);
    return vec3(ls.xy, divisor(ls.z));
}

bool is_silhouette(Instance instance, Edge edge) {
    vec3 a = seen(instance, edge.ends[0]);
    vec3 along = seen(instance, edge.ends[1]) - a;
    bool left = false;
    bool right = false;
    for (uint i = 0u; i < edge.count; i++) {
        float side = dot(a, cross(along, seen(instance, opposites[edge.first + i]) - a));
        left = left || side > 0.0;
        right = right || side < 0.0;
    }
    return left != right;
}

void main() {
    uint r = gl_WorkGroupID.x;
    EdgeRun run = runs[r];
    Instance instance = instances[run.instance];
    for (uint i = gl_LocalInvocationIndex; i < run.count; i += gl_WorkGroupSize.x) {
        if (is_silhouette(instance, edges[run.first + i])) {
            silhouettes[atomicAdd(vertex_count, 6u) / 6u] = r * RUN_EDGES + i;
        }
    }
}
