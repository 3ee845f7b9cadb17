#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/split.glsl"
#include "methods/izb_owner.glsl"

// What the camera sees, as the prepass draws it: which triangle each pixel's samples lie on. Vertices are fetched here, since only
// so is a triangle's number known.
layout(location = 0) out vec2 frag_uv;
layout(location = 1) out float frag_alpha;
layout(location = 2) flat out uvec2 owner;

void main() {
    Instance instance = instances[gl_InstanceIndex];
    uint vertex = indices[gl_VertexIndex];
    frag_uv = uintBitsToFloat(uvec2(attributes[3u * vertex], attributes[3u * vertex + 1u]));
    frag_alpha = float(attributes[3u * vertex + 2u] >> 24) / 255.0;
    owner = uvec2(gl_InstanceIndex, gl_VertexIndex / 3 + 1);
    gl_Position = frame.clip_from_eye * vec4(eye_to_instance(frame, instance) + linear(instance, position(vertex)), 1.0);
}
