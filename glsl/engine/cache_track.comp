#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/light.glsl"

// Compares every instance with what was known of it: which layer it is drawn into, which cached bounds it leaves and
// which it enters, and the runs of clusters of those that move.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint PAGE_TEXELS = 128u;
layout(constant_id = 1) const uint GUTTER = 0u;
layout(constant_id = 2) const bool TELL = false;  // whether `changes` is wanted
layout(constant_id = 3) const bool HOST_DRAWS = false;  // whether there are commands of casters that the host draws
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(std430, binding = 1) buffer CountersBlock { Counters counters; };
layout(std430, binding = 2) readonly buffer Instances { Instance instances[]; };
layout(std430, binding = 3) readonly buffer Meshes { MeshBounds meshes[]; };
layout(std430, binding = 4) buffer TrackedInstances { Tracked tracked[]; };
layout(std430, binding = 5) writeonly buffer Changed { vec4 changed[]; };  // centre and half size, along the world's axes
layout(std430, binding = 6) writeonly buffer Items { Item items[]; };
layout(std430, binding = 7) buffer Changes { uint changes[]; };  // whether any instance changed, then what of each: CHANGED_*
layout(std430, binding = 8) writeonly buffer HostDraws { DrawCommand host_draws[]; };
layout(push_constant) uniform Push {
    uint instance_count;
};

#include "shared/caster_bounds.glsl"

// A caster that moves again soon after it was cached waits longer the next time, up to this many times as long.
const uint MAX_PATIENCE = 16u;
const uint SOON = 4u;

bool same(Instance instance, Tracked known) {
    bool rows = floatBitsToUint(instance.low.xyz) == floatBitsToUint(known.low.xyz);
    for (uint i = 0u; i < 3u; i++) {
        rows = rows && floatBitsToUint(instance.rows[i]) == floatBitsToUint(known.rows[i]);
    }
    return rows && instance.revision == known.revision && instance.flags == known.flags &&
        instance.material == known.material && instance.mesh == known.mesh;
}

uint next_state(uint policy, bool moved, inout Tracked known) {
    uint patience = frame.cache.z;
    if (policy == POLICY_NEVER) {
        return CASTER_NONE;
    }
    if (policy == POLICY_ALWAYS) {
        return CASTER_DYNAMIC;
    }
    // what has just appeared counts as standing still
    if (policy == POLICY_STATIC || known.state == CASTER_UNKNOWN || known.state == CASTER_NONE) {
        known.patience = 0u;
        return CASTER_STATIC;
    }
    uint still = frame.cache.y - known.since;
    if (moved) {
        if (known.state == CASTER_STATIC) {
            // the first start is not a relapse: then `patience` is 0
            bool soon = still < SOON * known.patience;
            known.patience = soon ? min(2u * known.patience, MAX_PATIENCE * patience) : patience;
        }
        return CASTER_DYNAMIC;
    }
    return known.state == CASTER_DYNAMIC && still < known.patience ? CASTER_DYNAMIC : CASTER_STATIC;
}

void add_changed(Tracked known) {
    uint index = atomicAdd(counters.changed, 1u);
    changed[2u * index] = known.center;
    changed[2u * index + 1u] = known.reach;
}

void main() {
    uint index = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationIndex;
    if (index >= instance_count) {
        return;
    }
    Instance instance = instances[index];
    Tracked known = tracked[index];
    if ((frame.cache.x & FORGET_CASTERS) != 0u) {
        known.state = CASTER_UNKNOWN;
    }
    if (HOST_DRAWS && (instance.flags & HOST_DRAWN) != 0u) {
        // cull_host counts the pages of those that are drawn
        host_draws[index].instance_count = 0u;
    }
    bool moved = known.state == CASTER_UNKNOWN || !same(instance, known);
    uint before = known.state;
    uint state = next_state(instance.flags & 3u, moved, known);
    if (TELL) {
        bool shape = known.state == CASTER_UNKNOWN || known.state == CASTER_NONE || instance.revision != known.revision || instance.mesh != known.mesh;
        uint change = moved ? CHANGED_PLACE | (shape ? CHANGED_SHAPE : 0u) : 0u;
        // the revision of these need not be kept
        change |= (instance.flags & 3u) == POLICY_ALWAYS ? CHANGED_PLACE | CHANGED_SHAPE : 0u;
        changes[1u + index] = change;
        if (change != 0u) {
            changes[0] = 1u;
        }
    }
    Tracked old = known;
    if (moved) {
        Box box = mesh_box(instance, meshes[instance.mesh]);
        known.center = vec4(box.center, 0.0);
        known.reach = vec4(box_reach(box), 0.0);
    }
    if (moved || state != before) {
        // a first sight of everything changes nothing that is cached
        bool news = (frame.cache.x & FORGET_CASTERS) == 0u;
        if (news && before == CASTER_STATIC) {
            add_changed(old);
        }
        if (news && state == CASTER_STATIC) {
            add_changed(known);
        }
    }
    known.rows = instance.rows;
    known.low = instance.low;
    known.material = instance.material;
    known.mesh = instance.mesh;
    known.revision = instance.revision;
    known.flags = instance.flags;
    known.state = state;
    known.since = moved ? frame.cache.y : known.since;
    if (moved || state != before) {
        tracked[index] = known;
    }
    if (state == CASTER_DYNAMIC) {
        MeshBounds mesh = meshes[instance.mesh];
        uint runs = (mesh.cluster_count + RUN - 1u) / RUN;
        uint first = atomicAdd(counters.items[1], runs);
        for (uint i = 0u; i < runs && first + i < uint(items.length()); i++) {
            items[first + i] = Item(index, mesh.first_cluster + RUN * i);
        }
        atomicAdd(counters.dynamics, 1u);
    }
}
