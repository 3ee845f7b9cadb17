#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/receiver.glsl"

layout(constant_id = 0) const bool ALPHA_TEST = false;
layout(std430, binding = 2) readonly buffer Materials { Material materials[]; };
layout(std430, binding = 3) readonly buffer Texels { uint texels[]; };
layout(location = 0) in vec3 from_eye;
layout(location = 1) in vec2 frag_uv;
layout(location = 2) in vec4 frag_color;
layout(location = 3) flat in uint material;
layout(location = 0) out uint normal;
layout(location = 1) out vec4 albedo;

#include "shared/alpha.glsl"

void main() {
    // derivatives before the discard: afterwards they would be undefined
    vec3 n = cross(dFdx(from_eye), dFdy(from_eye));
    vec4 color = base_color(materials[material], frag_uv, frag_color);
    if (ALPHA_TEST && color.a < materials[material].alpha_cutoff) {
        discard;
    }
    n = normalize(n);
    normal = umbrage_encode_normal(dot(n, from_eye) > 0.0 ? -n : n);
    albedo = vec4(color.rgb, 1.0);
}
