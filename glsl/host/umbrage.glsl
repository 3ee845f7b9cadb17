// Shadows in a host's own shader: fragment, compute or any other. Define UMBRAGE_SET, the number at which
// `Engine::lookup(view).set` is bound, before the include, and as an option UMBRAGE_FILTER (1 regular, 2 Poisson disc, 3 bilinear;
// as `Filter`) with UMBRAGE_TAPS (2 to 9), for which `Config::gutter` must have room. Needs GL_GOOGLE_include_directive and
// the folder `glsl` as an include path (glslangValidator -V --target-env vulkan1.2 -I<crate>/glsl ...). All it declares begins with umbrage_ or Umbrage.
//
// World space has the axes of the host's; positions are relative to the eye of the view's frame. On edges the mask may differ: rays
// may have decided it, and derivatives of a shader's triangle need not be those of the surface.

#ifndef UMBRAGE_FILTER
#define UMBRAGE_FILTER 0
#endif
#ifndef UMBRAGE_TAPS
#define UMBRAGE_TAPS 4
#endif

#include "host/umbrage_names.glsl"
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

#include "host/umbrage_unnames.glsl"
#undef FILTER
#undef TAPS
#undef TABLE_SIZE
#undef GUTTER
#undef SUN
#undef LEVEL_BLEND
#undef RANGED
