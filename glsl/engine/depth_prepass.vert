#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"

layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(std430, binding = 1) readonly buffer Instances { Instance instances[]; };
layout(location = 0) in vec3 position;
layout(location = 1) in vec2 uv;
layout(location = 2) in vec4 color;
layout(location = 0) out vec3 from_eye;
layout(location = 1) out vec2 frag_uv;
layout(location = 2) out vec4 frag_color;
layout(location = 3) flat out uint material;

void main() {
    Instance instance = instances[gl_InstanceIndex];
    vec4 p = vec4(position, 1.0);
    from_eye = vec3(dot(instance.rows[0], p), dot(instance.rows[1], p), dot(instance.rows[2], p)) - frame.eye.xyz;
    frag_uv = uv;
    frag_color = color;
    material = instance.material;
    gl_Position = frame.clip_from_eye * vec4(from_eye, 1.0);
}
