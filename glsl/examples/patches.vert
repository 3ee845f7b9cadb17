#version 460

// The same through tessellation: what a draw is of goes along with its corners.
layout(location = 0) in vec3 position;
layout(location = 0) out vec3 corner;
layout(location = 1) out int corner_draw;

void main() {
    corner = position;
    corner_draw = gl_InstanceIndex;
}
