#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/structs.glsl"

// After an attempt: when it asked for more keys than fit, wipes its traces and lets the next, coarser attempt run.
layout(local_size_x = 256) in;
layout(constant_id = 0) const uint TABLE_SIZE = 1024u;
layout(constant_id = 1) const bool FLAGS = true;
layout(constant_id = 2) const uint CAPACITY = 1024u;
layout(std430, binding = 0) buffer CountersBlock { Counters counters; };
layout(std430, binding = 1) buffer TableKeys { uint table_keys[]; };
layout(std430, binding = 2) buffer Nodes { Node nodes[]; };
layout(std430, binding = 3) writeonly buffer Arguments { uint arguments[]; };
layout(push_constant) uniform Push {
    uint attempt;
    uint shift;     // of the next attempt
    uint groups_x;
    uint groups_y;
    uint argument;  // first word of the next attempt's dispatch arguments
};

void main() {
    bool again = counters.requests[attempt] > CAPACITY;
    uint id = gl_GlobalInvocationID.x;
    if (id == 0u) {
        arguments[argument] = again ? groups_x : 0u;
        arguments[argument + 1u] = groups_y;
        arguments[argument + 2u] = 1u;
        if (again) {
            counters.shift = shift;
            counters.failed = 0u;
        } else if (FLAGS && counters.requests[attempt] > 0u) {
            counters.leaves = counters.requests[attempt];
        }
    }
    if (again && FLAGS) {
        for (uint i = id; i < TABLE_SIZE; i += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
            if (table_keys[2u * i] != 0u) {
                table_keys[2u * i] = 0u;
                table_keys[2u * i + 1u] = 0u;
                nodes[i].own = 0u;
            }
        }
    }
}
