#version 460

layout(vertices = 3) out;
layout(location = 0) in vec3 corner[];
layout(location = 1) in int corner_draw[];
layout(location = 0) out vec3 patch_corner[];
layout(location = 1) patch out int draw;

void main() {
    patch_corner[gl_InvocationID] = corner[gl_InvocationID];
    draw = corner_draw[0];
    gl_TessLevelOuter[0] = gl_TessLevelOuter[1] = gl_TessLevelOuter[2] = 3.0;
    gl_TessLevelInner[0] = 3.0;
}
