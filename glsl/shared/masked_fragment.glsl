// Alpha and side test of a depth-only fragment; the includer defines MATERIALS_BINDING and TEXELS_BINDING.
layout(constant_id = 2) const uint CULL = 0u;  // sides of casters left out: 0 none, 1 back, 2 front
layout(std430, binding = MATERIALS_BINDING) readonly buffer Materials { Material materials[]; };
layout(std430, binding = TEXELS_BINDING) readonly buffer Texels { uint texels[]; };
layout(location = 0) in vec2 frag_uv;
layout(location = 1) in vec4 frag_color;
layout(location = 2) flat in uint material;
layout(location = 3) flat in uint mirrored;  // bit 0: the instance turns triangles over; a map's layer in those above

#include "shared/alpha.glsl"

// Whether a fragment is of a side that is left out, or cut away.
bool left_out() {
    bool front = gl_FrontFacing != ((mirrored & 1u) == 1u);
    if ((CULL == 1u && !front) || (CULL == 2u && front)) {
        return true;
    }
    return base_color(materials[material], frag_uv, frag_color).a < materials[material].alpha_cutoff;
}
