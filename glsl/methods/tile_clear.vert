#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_ARB_shader_viewport_layer_array : require

// One triangle over each layer whose tile is drawn, at the far end of the depth range; nothing over the others.
layout(std430, binding = 0) readonly buffer Drawn { uint drawn[]; };

void main() {
    vec2 corner = vec2(gl_VertexIndex == 1 ? 3.0 : -1.0, gl_VertexIndex == 2 ? 3.0 : -1.0);
    gl_Position = vec4(drawn[gl_InstanceIndex] != 0u ? corner : vec2(-1.0), 0.0, 1.0);
    gl_Layer = gl_InstanceIndex;
}
