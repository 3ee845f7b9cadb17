// Position of a caster's vertex in one layer of a map.
#include "methods/map_place.glsl"
layout(constant_id = 0) const uint LAYER = 0u;
layout(constant_id = 3) const uint TILES = 0u;  // 1: layer and instance are those of a pair
#include "methods/tile.glsl"
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
    vec4 place = map_place(instance, position, layer);
    gl_Position = vec4(2.0 * place.xy - place.z, place.w, place.z);
    gl_Layer = int(layer);
}
