#version 460
#extension GL_GOOGLE_include_directive : require
#include "host/umbrage_normal.glsl"

layout(location = 0) in vec3 from_eye;
layout(location = 0) out vec4 color;
layout(location = 1) out uint normal;

void main() {
    vec3 n = normalize(cross(dFdx(from_eye), dFdy(from_eye)));
    n = dot(n, from_eye) > 0.0 ? -n : n;
    color = vec4(0.5 + 0.4 * n, 1.0);
    normal = umbrage_encode_normal(n);
}
