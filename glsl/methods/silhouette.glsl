// Silhouette maps (Sen, Cammarano, Hanrahan 2003): edges of the scene and those that the light sees as silhouettes. The includer
// declares light.glsl and, before this file, SILHOUETTE_BINDING, the first of six bindings: runs, edges, opposites, positions,
// instances and the list; LIST_ACCESS is readonly where the list is only read.
layout(constant_id = 3) const uint POSITION_STRIDE = 3u;
layout(constant_id = 4) const uint POSITION_OFFSET = 0u;
layout(constant_id = 5) const uint POSITION_FORMAT = 0u;

// An edge of a mesh.
struct Edge {
    uint ends[2];  // vertices
    uint first;    // entry in the opposites
    uint count;    // triangles that share the edge: corners of them that do not lie on it
};

// At most RUN_EDGES edges of a mesh, of one instance. Edge i of run r has the number r * RUN_EDGES + i.
struct EdgeRun {
    uint instance;
    uint first;
    uint count;
};

const uint RUN_EDGES = 256u;

layout(std430, binding = SILHOUETTE_BINDING) readonly buffer Runs { EdgeRun runs[]; };
layout(std430, binding = SILHOUETTE_BINDING + 1) readonly buffer Edges { Edge edges[]; };
layout(std430, binding = SILHOUETTE_BINDING + 2) readonly buffer Opposites { uint opposites[]; };
layout(std430, binding = SILHOUETTE_BINDING + 3) readonly buffer Positions { uint positions[]; };
layout(std430, binding = SILHOUETTE_BINDING + 4) readonly buffer Instances { Instance instances[]; };
// a draw without indices, then the numbers of the silhouette edges, in any order
layout(std430, binding = SILHOUETTE_BINDING + 5) LIST_ACCESS buffer List {
    uint vertex_count;
    uint instance_count;
    uint first_vertex;
    uint first_instance;
    uint silhouettes[];
};

#include "shared/position.glsl"

// A vertex, relative to the scene's origin.
vec3 world_position(Instance instance, uint vertex) {
    vec4 p = vec4(position(vertex), 1.0);
    return vec3(dot(instance.rows[0], p), dot(instance.rows[1], p), dot(instance.rows[2], p));
}
