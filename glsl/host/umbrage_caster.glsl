// Casters that the host draws with pipelines of its own into the pages of the shadow map: vertex or tessellation evaluation
// shader. Define UMBRAGE_CASTER_SET, the number at which `Engine::casters().set` is bound, before the include. Needs
// GL_GOOGLE_include_directive, GL_ARB_shader_viewport_layer_array (for gl_Layer) and the folder `glsl` as an include path:
//     glslangValidator -V --target-env vulkan1.2 -I<crate>/glsl ...
// (older targets make of gl_Layer an extension that is not enabled). All it declares begins with umbrage_ or Umbrage. Not together with umbrage.glsl in one shader.
//
//     gl_Position = umbrage_caster_position(gl_InstanceIndex, umbrage_caster_vector(gl_InstanceIndex, position));
//     gl_Layer = umbrage_caster_layer(gl_InstanceIndex);
//
// Each instance of such a draw is one of the pages that the caster touches, and gl_InstanceIndex tells which: hand it
// on to a tessellation evaluation shader, as `draw` below. What a caster looks like must not depend on the page nor on the camera: pages are kept.

#include "host/umbrage_names.glsl"
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/light.glsl"
#include "shared/linear.glsl"
#include "shared/page_place.glsl"
layout(std140, set = UMBRAGE_CASTER_SET, binding = 0) uniform UmbrageFrameBlock { Frame frame; };
layout(std430, set = UMBRAGE_CASTER_SET, binding = 1) readonly buffer UmbrageLights { Light lights[]; };
layout(std430, set = UMBRAGE_CASTER_SET, binding = 2) readonly buffer UmbragePages { Page pages[]; };
layout(std430, set = UMBRAGE_CASTER_SET, binding = 3) readonly buffer UmbragePairs { Pair pairs[]; };
layout(std430, set = UMBRAGE_CASTER_SET, binding = 4) readonly buffer UmbrageInstances { Instance instances[]; };

// Number of the instance that is drawn: index into `SceneBuffers::instances` and what the host keeps beside it.
uint umbrage_caster_instance(int draw) { return pairs[draw].instance; }

// The way from the instance's place (the translation of its matrix) to a point of its mesh: world axes, world units.
vec3 umbrage_caster_vector(int draw, vec3 position) { return linear(instances[pairs[draw].instance], position); }

// gl_Position of a point, given the way to it from the instance's place: world axes, world units, displaced as the host likes
// within the bounds of the instance's mesh.
vec4 umbrage_caster_position(int draw, vec3 from_place) {
    Pair pair = pairs[draw];
    Page page = pages[pair.target >> 1];
    float gutter = float(frame.lights.z);
    return place_in_page(lights[key_face(page.key) / FACES], page, pair, from_place, frame.rule.x + 2.0 * gutter, gutter);
}

// gl_Layer of everything that is drawn.
int umbrage_caster_layer(int draw) {
    Pair pair = pairs[draw];
    return pair_layer(pages[pair.target >> 1], pair);
}
#include "host/umbrage_unnames.glsl"
