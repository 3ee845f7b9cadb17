#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/split.glsl"
#include "methods/izb_owner.glsl"

layout(constant_id = 3) const bool ALPHA = false;  // whether the casters are alpha tested
layout(location = 0) in vec2 frag_uv;
layout(location = 1) in float frag_alpha;
layout(location = 2) flat in uvec2 owner;
layout(location = 0) out uvec2 seen;

void main() {
    if (ALPHA) {
        Material material = materials[instances[owner.x].material];
        if (base_color(material, frag_uv, vec4(1.0, 1.0, 1.0, frag_alpha)).a < material.alpha_cutoff) {
            discard;
        }
    }
    seen = owner;
}
