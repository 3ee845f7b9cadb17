// Position of a caster's vertex in its page: texels relative to the page's own corner, so that a page's content depends
// on its address and its casters only.
#include "shared/linear.glsl"

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
    uint face = key_face(page.key);
    Light light = lights[face / FACES];
    vec3 ls = vec3(pair.anchor[0], pair.anchor[1], pair.anchor[2]) + light_axes(light, linear(instance, position));
    float w = 1.0;
    float depth = -ls.z * light.scale.z;
    if (light.kind.x != LIGHT_DIRECTIONAL) {
        ls = face_axes(face % FACES, ls);
        w = ls.z;
        ls.xy -= page.origin * w;
        depth = light.scale.z;
    }
    vec2 texel = ls.xy * page.scale + float(GUTTER) * w;
    gl_Position = vec4(texel * (2.0 / float(PAGE_TEXELS)) - w, depth, w);
    gl_Layer = int((pair.target & 1u) == 0u ? page.slot : page.dynamic_slot);
}
