#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/split.glsl"

// The scene as the camera sees it, with the numbers of its triangles.
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(std430, binding = 2) readonly buffer Instances { Instance instances[]; };
#include "methods/ids_vertex.glsl"

void main() {
    Instance instance = instances[gl_InstanceIndex];
    vec3 from_eye = eye_to_instance(frame, instance) + linear(instance, fetch_vertex(instance));
    gl_Position = frame.clip_from_eye * vec4(from_eye, 1.0);
}
