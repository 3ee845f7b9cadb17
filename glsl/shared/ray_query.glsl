// Whether a ray meets a caster, by a ray query (VK_KHR_ray_query) into the structure that query_instances.comp places. The
// includer defines RAY_BINDING, the first of nine bindings, and includes shared/structs.glsl, shared/split.glsl and
// shared/receiver.glsl; constants 0 to 3 are taken. Space is relative to the eye of `frame`, as the structure is.
layout(constant_id = 0) const uint CULL = 0u;  // sides of casters left out: 0 none, 1 back, 2 front
layout(constant_id = 1) const bool ALPHA = true;  // whether any caster is alpha tested
layout(binding = RAY_BINDING) uniform accelerationStructureEXT casters;
layout(std430, binding = RAY_BINDING + 6) readonly buffer Meshes { MeshBounds meshes[]; };
layout(std430, binding = RAY_BINDING + 7) readonly buffer Clusters { Cluster clusters[]; };
layout(std430, binding = RAY_BINDING + 8) readonly buffer Indices { uint indices[]; };

#define RAY_CONSTANT 2
#include "shared/ray_hit.glsl"

const float FAR = 3e38;  // queries take no infinity

// A triangle of the structure and a point of it.
Met met_at(Instance instance, uint primitive, vec2 barycentrics) {
    uint first = clusters[meshes[instance.mesh].first_cluster].first_index + 3u * primitive;
    Met met;
    met.triangle = first / 3u;
    met.vertices = uvec3(indices[first], indices[first + 1u], indices[first + 2u]);
    met.weights = vec3(1.0 - barycentrics.x - barycentrics.y, barycentrics);
    return met;
}

// As `occluded` of ray.glsl.
bool occluded(vec3 origin, vec3 direction, float t_max, float snap, inout Surface surface) {
    bool search = snap > 0.0;
    vec3 from = search ? origin - SEARCH * direction : origin;
    float end = search ? 2.0 * SEARCH : min(t_max, FAR);
    vec3 d = abs(direction), o = abs(from);
    // what is not finite meets nothing, nor does what has no direction
    if (!(max(max(d.x, d.y), d.z) > 0.0 && d.x + d.y + d.z < FAR && o.x + o.y + o.z < FAR && end > 0.0)) {
        return false;
    }
    uint flags = gl_RayFlagsTerminateOnFirstHitEXT;
    // the receiver sees the other sides than the light; either way sides are those of the mesh, whatever matrices mirror
    flags |= CULL == 1u ? gl_RayFlagsCullFrontFacingTrianglesEXT : 0u;
    flags |= CULL == 2u ? gl_RayFlagsCullBackFacingTrianglesEXT : 0u;
    // only alpha, a surface to leave out and a search need a look at what is met
    flags |= search || surface.triangle != NO_TRIANGLE ? gl_RayFlagsNoOpaqueEXT : 0u;
    rayQueryEXT query;
    rayQueryInitializeEXT(query, casters, flags, 0xffu, from, 0.0, direction, end);
    while (rayQueryProceedEXT(query)) {
        uint index = rayQueryGetIntersectionInstanceCustomIndexEXT(query, false);
        Instance instance = instances[index];
        uint primitive = rayQueryGetIntersectionPrimitiveIndexEXT(query, false);
        Met met = met_at(instance, primitive, rayQueryGetIntersectionBarycentricsEXT(query, false));
        bool own = !search && index == surface.instance && met.triangle == surface.triangle;
        if (own || ALPHA && (instance.flags & ALPHA_TESTED) != 0u && !solid(index, met)) {
            continue;
        }
        if (!search) {
            rayQueryConfirmIntersectionEXT(query);
            continue;
        }
        float t = plane_t(instance, met, origin, direction);
        if (abs(t) < snap) {
            snap = max(abs(t), 1e-30);
            surface = Surface(index, met.triangle, t);
        }
    }
    return rayQueryGetIntersectionTypeEXT(query, true) != gl_RayQueryCommittedIntersectionNoneEXT;
}
