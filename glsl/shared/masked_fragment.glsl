// Alpha test of a depth-only fragment; the includer defines MATERIALS_BINDING and TEXELS_BINDING.
layout(std430, binding = MATERIALS_BINDING) readonly buffer Materials { Material materials[]; };
layout(std430, binding = TEXELS_BINDING) readonly buffer Texels { uint texels[]; };
layout(location = 0) in vec2 frag_uv;
layout(location = 1) in vec4 frag_color;
layout(location = 2) flat in uint material;

#include "shared/alpha.glsl"

void main() {
    if (base_color(materials[material], frag_uv, frag_color).a < materials[material].alpha_cutoff) {
        discard;
    }
}
