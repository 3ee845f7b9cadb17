#version 460
#extension GL_GOOGLE_include_directive : require
#include "examples/sway.glsl"

// The host's own pass: colour, depth, and the geometric normal that Umbrage may be given.
layout(push_constant) uniform Push {
    mat4 clip_from_mesh;
    vec4 rows[3];  // from the eye, world axes, from mesh space
    float wind;
};
layout(location = 0) in vec3 position;
layout(location = 0) out vec3 from_eye;

void main() {
    vec4 p = vec4(sway(position, wind), 1.0);
    from_eye = vec3(dot(rows[0], p), dot(rows[1], p), dot(rows[2], p));
    gl_Position = clip_from_mesh * p;
}
