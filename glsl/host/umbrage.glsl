// Shadows in a host's own shader: fragment, compute or any other. Define UMBRAGE_SET, the number at which
// `Engine::lookup(view).set` is bound, before the include, and as an option UMBRAGE_FILTER (1 regular, 2 Poisson disc, 3 bilinear;
// as `Filter`) with UMBRAGE_TAPS (2 to 9), for which `Config::gutter` must have room. Needs GL_GOOGLE_include_directive and
// the folder of this one and `shared` as an include path. All it declares begins with umbrage_ or Umbrage.
//
// World space has the axes of the host's; positions are relative to the eye of the view's frame.

#ifndef UMBRAGE_FILTER
#define UMBRAGE_FILTER 0
#endif
#ifndef UMBRAGE_TAPS
#define UMBRAGE_TAPS 4
#endif

// what the engine's own files call by shorter names
#define atlas umbrage_atlas
#define BLEND_BAND UMBRAGE_BLEND_BAND
#define box_visibility umbrage_box_visibility
#define box_weights umbrage_box_weights
#define caster_quad umbrage_caster_quad
#define contour_visibility umbrage_contour_visibility
#define cube_face umbrage_cube_face
#define decode_derivatives umbrage_decode_derivatives
#define decode_normal umbrage_decode_normal
#define DISC UMBRAGE_DISC
#define DISC_SAMPLES UMBRAGE_DISC_SAMPLES
#define disc_visibility umbrage_disc_visibility
#define entries umbrage_entries
#define entry_dynamic umbrage_entry_dynamic
#define entry_level umbrage_entry_level
#define entry_slot umbrage_entry_slot
#define entry_turned umbrage_entry_turned
#define face_axes umbrage_face_axes
#define FACES UMBRAGE_FACES
#define FILTER_BILINEAR UMBRAGE_FILTER_BILINEAR
#define FILTER_HARD UMBRAGE_FILTER_HARD
#define FILTER_PCF UMBRAGE_FILTER_PCF
#define FILTER_POISSON UMBRAGE_FILTER_POISSON
#define footprint_level umbrage_footprint_level
#define FORGET_CASTERS UMBRAGE_FORGET_CASTERS
#define FORGET_PAGES UMBRAGE_FORGET_PAGES
#define Frame UmbrageFrame
#define frame umbrage_frame
#define HALF UMBRAGE_HALF
#define hash umbrage_hash
#define is_surface umbrage_is_surface
#define kernel_reach umbrage_kernel_reach
#define kernel_visibility umbrage_kernel_visibility
#define key_ancestor umbrage_key_ancestor
#define key_face umbrage_key_face
#define key_hash umbrage_key_hash
#define key_level umbrage_key_level
#define key_of umbrage_key_of
#define key_page umbrage_key_page
#define key_quadrant umbrage_key_quadrant
#define layer_count umbrage_layer_count
#define layer_depth umbrage_layer_depth
#define layer_of umbrage_layer_of
#define layer_quad umbrage_layer_quad
#define Light UmbrageLight
#define light_axes umbrage_light_axes
#define LIGHT_CUBE UMBRAGE_LIGHT_CUBE
#define LIGHT_DIRECTIONAL UMBRAGE_LIGHT_DIRECTIONAL
#define LIGHT_NONE UMBRAGE_LIGHT_NONE
#define light_receiver umbrage_light_receiver
#define LIGHT_SPOT UMBRAGE_LIGHT_SPOT
#define lights umbrage_lights
#define linear umbrage_linear
#define linear_depth umbrage_linear_depth
#define make_entry umbrage_make_entry
#define MAX_PROBES UMBRAGE_MAX_PROBES
#define NONE UMBRAGE_NONE
#define on_face umbrage_on_face
#define pixel_ray umbrage_pixel_ray
#define pixel_turn umbrage_pixel_turn
#define Plane UmbragePlane
#define power_of_two umbrage_power_of_two
#define ranges umbrage_ranges
#define ray_offset umbrage_ray_offset
#define Receiver UmbrageReceiver
#define receiver_bias umbrage_receiver_bias
#define ROOT_LEVEL UMBRAGE_ROOT_LEVEL
#define table_find umbrage_table_find
#define table_key umbrage_table_key
#define table_keys umbrage_table_keys
#define table_slot umbrage_table_slot
#define FILTER uint(UMBRAGE_FILTER)
#define TAPS uint(UMBRAGE_TAPS)
#define TABLE_SIZE uint(entries.length())
#define GUTTER frame.lights.z
#define SUN false
#define LEVEL_BLEND ((frame.lights.w & 1u) != 0u)
#define RANGED ((frame.lights.w & 2u) != 0u)

#include "shared/frame.glsl"
#include "shared/key.glsl"
#include "shared/light.glsl"
#include "shared/receiver.glsl"
layout(std140, set = UMBRAGE_SET, binding = 0) uniform UmbrageFrameBlock { Frame frame; };
layout(std430, set = UMBRAGE_SET, binding = 1) readonly buffer UmbrageTableKeys { uint table_keys[]; };
layout(std430, set = UMBRAGE_SET, binding = 2) readonly buffer UmbrageEntries { uint entries[]; };
layout(set = UMBRAGE_SET, binding = 3) uniform sampler2DArray atlas;
layout(std430, set = UMBRAGE_SET, binding = 4) readonly buffer UmbrageLights { Light lights[]; };
layout(std430, set = UMBRAGE_SET, binding = 5) readonly buffer UmbrageRanges { vec2 ranges[]; };
#include "shared/light_receiver.glsl"
#include "shared/table.glsl"
#include "host/umbrage_lookup.glsl"
#include "host/umbrage_filter.glsl"

// How much of a light reaches a point: 1 all of it, 0 none. `slot`: of the light, `LightId::slot`; `from_eye`: the point;
// `n`: geometric normal towards the eye; `dx`, `dy`: change of the point from a pixel to the next on its surface (dFdx, dFdy of
// `from_eye` in a fragment shader); `pixel`: for the rotation of the Poisson disc.
float umbrage_shadow(uint slot, vec3 from_eye, vec3 n, vec3 dx, vec3 dy, uvec2 pixel) {
    if (slot >= frame.lights.x) {
        return 0.0;
    }
    Light light = lights[frame.size.w + slot];
    if (light.kind.x == LIGHT_NONE) {
        return 0.0;
    }
#if UMBRAGE_FILTER == 0
    return umbrage_visibility(slot, light, from_eye, n, dx, dy);
#else
    return umbrage_filtered(slot, light, from_eye, n, dx, dy, pixel);
#endif
}

#undef atlas
#undef BLEND_BAND
#undef box_visibility
#undef box_weights
#undef caster_quad
#undef contour_visibility
#undef cube_face
#undef decode_derivatives
#undef decode_normal
#undef DISC
#undef DISC_SAMPLES
#undef disc_visibility
#undef entries
#undef entry_dynamic
#undef entry_level
#undef entry_slot
#undef entry_turned
#undef face_axes
#undef FACES
#undef FILTER
#undef FILTER_BILINEAR
#undef FILTER_HARD
#undef FILTER_PCF
#undef FILTER_POISSON
#undef footprint_level
#undef FORGET_CASTERS
#undef FORGET_PAGES
#undef Frame
#undef frame
#undef GUTTER
#undef HALF
#undef hash
#undef is_surface
#undef kernel_reach
#undef kernel_visibility
#undef key_ancestor
#undef key_face
#undef key_hash
#undef key_level
#undef key_of
#undef key_page
#undef key_quadrant
#undef layer_count
#undef layer_depth
#undef layer_of
#undef layer_quad
#undef LEVEL_BLEND
#undef Light
#undef light_axes
#undef LIGHT_CUBE
#undef LIGHT_DIRECTIONAL
#undef LIGHT_NONE
#undef light_receiver
#undef LIGHT_SPOT
#undef lights
#undef linear
#undef linear_depth
#undef make_entry
#undef MAX_PROBES
#undef NONE
#undef on_face
#undef pixel_ray
#undef pixel_turn
#undef Plane
#undef power_of_two
#undef RANGED
#undef ranges
#undef ray_offset
#undef Receiver
#undef receiver_bias
#undef ROOT_LEVEL
#undef SUN
#undef table_find
#undef table_key
#undef table_keys
#undef TABLE_SIZE
#undef table_slot
#undef TAPS
