// Position of a caster's vertex in one layer of a map.
#include "methods/map_place.glsl"
layout(location = 0) in vec3 position;

void place_vertex(out Instance instance) {
    instance = instances[gl_InstanceIndex];
    vec4 place = map_place(instance, position);
    gl_Position = vec4(2.0 * place.xy - place.z, place.w, place.z);
    gl_Layer = int(LAYER);
}
