#version 460

// Dispatch size of a pass with a thread for each item.
layout(local_size_x = 1) in;
layout(std430, binding = 0) readonly buffer Count { uint count; };
layout(std430, binding = 1) writeonly buffer Arguments { uint arguments[]; };
layout(push_constant) uniform Push { uint capacity; };

const uint DISPATCH_X = 32768u;

void main() {
    uint groups = (min(count, capacity) + 63u) / 64u;
    arguments[0] = min(groups, DISPATCH_X);
    arguments[1] = (groups + DISPATCH_X - 1u) / DISPATCH_X;
    arguments[2] = 1u;
}
