// Where a layer of a map has a point of a caster.
#define LIGHT_BINDING 0
#include "methods/light.glsl"
layout(std430, binding = 1) readonly buffer Fits { Fit fits[]; };
layout(std430, binding = 2) readonly buffer Instances { Instance instances[]; };

// Homogeneous map coordinates, [0, 1]^2, and in w the stored depth times what divides all four. `precise`: a vertex of two
// triangles lies in one place.
vec4 map_place(Instance instance, vec3 position, uint layer) {
    precise vec4 p = vec4(position, 1.0);
    precise vec3 world = vec3(dot(instance.rows[0], p), dot(instance.rows[1], p), dot(instance.rows[2], p));
    uint face = face_of(layer);
    precise vec3 ls = light_space(face, world - light.eye.xyz);
    // depth does not pass through the eye, which may be far away
    ls.z = dot(light.faces[face].z.xyz, world) + light.faces[face].origin.x;
    precise vec3 t = vec3(ls.xy, divisor(ls.z));
    Fit fit = fits[layer];
    precise vec4 place = vec4(dot(fit.row_u.xyz, t), dot(fit.row_v.xyz, t), dot(fit.row_w.xyz, t), light.depth.x * ls.z + light.depth.y);
    return place;
}
