#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_ARB_shader_viewport_layer_array : require

// One triangle over each layer that is about to be drawn, at the far end of the depth range.
layout(std430, binding = 0) readonly buffer Cleared { uint cleared[]; };

void main() {
    gl_Position = vec4(gl_VertexIndex == 1 ? 3.0 : -1.0, gl_VertexIndex == 2 ? 3.0 : -1.0, 0.0, 1.0);
    gl_Layer = int(cleared[gl_InstanceIndex]);
}
