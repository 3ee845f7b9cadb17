#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/structs.glsl"
#include "methods/fit.glsl"

// Has the tiles drawn again that a caster touches, or touched, which is not what it was in the last frame: moved, deformed or
// otherwise changed. A thread looks after an instance.
layout(local_size_x = 64) in;
layout(constant_id = 0) const float SIDE = 128.0;
#define LIGHT_BINDING 0
#include "methods/light.glsl"
#include "methods/tile_bounds.glsl"
#include "methods/asm_counts.glsl"

// An instance as it was drawn last, and the bounds of its mesh.
struct Known {
    Instance instance;
    vec4 center;
    vec4 extent;
};

layout(std430, binding = 1) readonly buffer Fits { Fit fits[]; };
layout(std430, binding = 2) readonly buffer Instances { Instance instances[]; };
layout(std430, binding = 3) readonly buffer Meshes { MeshBounds meshes[]; };
layout(std430, binding = 4) buffer KnownInstances { Known known[]; };
layout(std430, binding = 5) buffer Drawn { uint drawn[]; };
layout(std430, binding = 6) buffer Counts { AsmCounts counts; };
layout(push_constant) uniform Push {
    uint instance_count;
    uint tiles;
    uint reset;  // 1: all that is drawn is drawn anew
};

bool same(Instance a, Instance b) {
    bool rows = floatBitsToUint(a.low) == floatBitsToUint(b.low);
    for (uint i = 0u; i < 3u; i++) {
        rows = rows && floatBitsToUint(a.rows[i]) == floatBitsToUint(b.rows[i]);
    }
    return rows && a.material == b.material && a.mesh == b.mesh && a.revision == b.revision && a.flags == b.flags;
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= instance_count) {
        return;
    }
    Known before = known[index];
    Instance instance = instances[index];
    bool changed = reset == 1u || !same(before.instance, instance);
    if (!changed) {
        return;
    }
    MeshBounds mesh = meshes[instance.mesh];
    Known now = Known(instance, vec4(mesh.center[0], mesh.center[1], mesh.center[2], 0.0), vec4(mesh.extent[0], mesh.extent[1], mesh.extent[2], 0.0));
    known[index] = now;
    uint end = reset == 0u ? tiles : 0u;
    for (uint tile = 0u; tile < end; tile++) {
        Fit fit = fits[tile];
        bool is_page = fit.texel.x > 0.0;
        bool touched = touches(fit, before.instance, before.center.xyz, before.extent.xyz, SIDE) ||
            touches(fit, instance, now.center.xyz, now.extent.xyz, SIDE);
        if (is_page && touched && atomicExchange(drawn[tile], 1u) == 0u) {
            atomicAdd(counts.stale, 1u);
        }
    }
}
