// The tree over all casters, in one buffer of uvec4 that the includer declares as `tree`. No pointers: where a node's
// children lie follows from its level and its path (two bits a level), so a walk ends whatever the buffer holds.
//
// From 0: top nodes, three words each: x, y and z of four boxes, low | high << 16, in 1/65535 of the scene's bounds. Level L
// begins at node (4^L - 1) / 3; the children of the last level are casters.
// From CASTERS: casters in their sorted order, four words each.
// From NODES: nodes of clusters, two words each: low and high corners of four boxes, 10 bits an axis, in 1/1023 of the
// cluster's bounds. The children of the last level are leaves of LEAF triangles. A cluster's root is at a third of the
// number of its first triangle, which leaves room for its nodes: with n triangles no more than n / 3.
// From TRIANGLES: the three vertices of each triangle, sorted within clusters; w is unused.

layout(constant_id = 0) const uint CASTER_COUNT = 1u;  // casters at most
layout(constant_id = 1) const uint TOP_LEVELS = 1u;    // levels of top nodes
layout(constant_id = 2) const uint CASTERS = 0u;
layout(constant_id = 3) const uint NODES = 0u;
layout(constant_id = 4) const uint TRIANGLES = 0u;
layout(constant_id = 5) const float LOW_X = 0.0;    // lower corner of the scene's bounds
layout(constant_id = 6) const float LOW_Y = 0.0;
layout(constant_id = 7) const float LOW_Z = 0.0;
layout(constant_id = 8) const float STEPS_X = 1.0;  // 65535 / size of the scene's bounds
layout(constant_id = 9) const float STEPS_Y = 1.0;
layout(constant_id = 10) const float STEPS_Z = 1.0;

const uint LEAF = 2u;
const uint TOP_EMPTY = 0xffffu;  // low above high
const float TOP_STEPS = 65535.0;
const float CLUSTER_STEPS = 1023.0;

// A cluster of an instance.
struct Caster {
    vec4 rows[3];   // to steps of the cluster's bounds from world space relative to the scene's origin; 0 where the instance is flat
    uint instance;
    uint first;     // triangle of the scene
    uint count;     // triangles; MIRRORED, MASKED
    float margin;   // by which boxes grow for the rounding of rays, in steps
};

const uint MIRRORED = 0x80000000u;  // the instance turns triangles over
const uint MASKED = 0x40000000u;    // triangles are tested against alpha

vec3 top_steps(vec3 world) { return (world - vec3(LOW_X, LOW_Y, LOW_Z)) * vec3(STEPS_X, STEPS_Y, STEPS_Z); }

// The first node of a level.
uint level_begin(uint level) { return 0x55555555u & ((1u << (2u * level)) - 1u); }

// Levels of nodes over n triangles.
uint cluster_levels(uint n) { return n <= LEAF ? 0u : n <= 4u * LEAF ? 1u : n <= 16u * LEAF ? 2u : 3u; }
