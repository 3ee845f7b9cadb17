// A vertex of a caster that the engine draws into a page.
#include "shared/linear.glsl"
#include "shared/page_place.glsl"

layout(constant_id = 0) const uint PAGE_TEXELS = 128u;
layout(constant_id = 1) const uint GUTTER = 0u;
layout(std430, binding = 0) readonly buffer Lights { Light lights[]; };
layout(std430, binding = 1) readonly buffer Pages { Page pages[]; };
layout(std430, binding = 2) readonly buffer Pairs { Pair pairs[]; };
layout(std430, binding = 3) readonly buffer Instances { Instance instances[]; };
layout(location = 0) in vec3 position;

// Writes gl_Position and gl_Layer; hands out the instance.
void place_vertex(out Instance instance) {
    Pair pair = pairs[gl_InstanceIndex];
    Page page = pages[pair.target >> 1];
    instance = instances[pair.instance];
    Light light = lights[key_face(page.key) / FACES];
    gl_Position = place_in_page(light, page, pair, linear(instance, position), float(PAGE_TEXELS), float(GUTTER));
    gl_Layer = pair_layer(page, pair);
}
