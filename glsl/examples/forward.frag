#version 460
#extension GL_GOOGLE_include_directive : require
#define UMBRAGE_SET 0
#include "host/umbrage.glsl"

// The host's colour pass where shadows are looked up in it, without a mask.
layout(location = 0) in vec3 from_eye;
layout(location = 0) out vec4 color;

void main() {
    vec3 dx = dFdx(from_eye), dy = dFdy(from_eye);
    vec3 n = normalize(cross(dx, dy));
    n = dot(n, from_eye) > 0.0 ? -n : n;
    float visibility = umbrage_shadow(0u, from_eye, n, dx, dy, uvec2(gl_FragCoord.xy));
    color = vec4((0.5 + 0.4 * n) * mix(0.33, 1.0, visibility), visibility);
}
