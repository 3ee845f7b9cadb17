#version 460

// Lengths of the lists, for statistics and pictures.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint COUNT = 64u;  // lists
layout(std430, binding = 0) readonly buffer Heads { uint heads[]; };
layout(std430, binding = 1) readonly buffer Listed { uvec4 listed[]; };
layout(std430, binding = 2) writeonly buffer Lengths { uint lengths[]; };

void main() {
    uint list = gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * 64u * gl_NumWorkGroups.x;
    if (list >= COUNT) {
        return;
    }
    uint count = 0u;
    for (uint next = heads[list]; next != 0u; next = listed[next - 1u].w) {
        count++;
    }
    lengths[list] = count;
}
