#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"

#include "shared/split.glsl"

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
    from_eye = eye_to_instance(frame, instance) + linear(instance, position);
    frag_uv = uv;
    frag_color = color;
    material = instance.material;
    gl_Position = frame.clip_from_eye * vec4(from_eye, 1.0);
}
