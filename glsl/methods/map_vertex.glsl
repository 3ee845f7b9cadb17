// Position of a caster's vertex in one layer of a map.
layout(constant_id = 0) const uint LAYER = 0u;
layout(constant_id = 3) const uint TILES = 0u;  // 1: layer and instance are those of a pair
#define LIGHT_BINDING 0
#include "methods/light.glsl"
#include "methods/tile.glsl"
layout(std430, binding = 1) readonly buffer Fits { Fit fits[]; };
layout(std430, binding = 2) readonly buffer Instances { Instance instances[]; };
layout(std430, binding = 3) readonly buffer Pairs { TilePair pairs[]; };  // with TILES

// Writes gl_Position and gl_Layer of a vertex at `position` in its mesh; hands out instance and layer.
void place_vertex(vec3 position, out Instance instance, out uint layer) {
    layer = LAYER;
    uint index = gl_InstanceIndex;
    if (TILES == 1u) {
        layer = pairs[gl_InstanceIndex].tile;
        index = pairs[gl_InstanceIndex].instance;
    }
    instance = instances[index];
    vec4 p = vec4(position, 1.0);
    vec3 world = vec3(dot(instance.rows[0], p), dot(instance.rows[1], p), dot(instance.rows[2], p));
    uint face = face_of(layer);
    vec3 ls = light_space(face, world - light.eye.xyz);
    // depth does not pass through the eye, which may be far away
    ls.z = dot(light.faces[face].z.xyz, world) + light.faces[face].origin.x;
    float w = divisor(ls.z);
    vec3 t = vec3(ls.xy, w);
    Fit fit = fits[layer];
    vec3 uvw = vec3(dot(fit.row_u.xyz, t), dot(fit.row_v.xyz, t), dot(fit.row_w.xyz, t));
    gl_Position = vec4(2.0 * uvw.xy - uvw.z, light.depth.x * ls.z + light.depth.y, uvw.z);
    gl_Layer = int(layer);
}
