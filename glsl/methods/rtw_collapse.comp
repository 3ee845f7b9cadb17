#version 460
#extension GL_GOOGLE_include_directive : require

// The greatest importance of each column and of each row (Rosen 2012, 4.2, step i). A thread walks down 32 rows of a column.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint CELLS = 512u;
layout(std430, binding = 0) readonly buffer Importance { uint importance[]; };
layout(std430, binding = 1) buffer Collapsed { uint collapsed[]; };  // along u, then along v; floats, which are not negative

const uint ROWS = 32u;
shared uint rows[ROWS];

void main() {
    uint column = gl_GlobalInvocationID.x;
    if (gl_LocalInvocationIndex < ROWS) {
        rows[gl_LocalInvocationIndex] = 0u;
    }
    barrier();
    uint most = 0u;
    for (uint r = 0u; r < ROWS; r++) {
        uint row = gl_WorkGroupID.y * ROWS + r;
        uint bits = column < CELLS && row < CELLS ? importance[row * CELLS + column] : 0u;
        most = max(most, bits);
        if (bits != 0u) {
            atomicMax(rows[r], bits);
        }
    }
    if (most != 0u) {
        atomicMax(collapsed[column], most);
    }
    barrier();
    uint row = gl_WorkGroupID.y * ROWS + gl_LocalInvocationIndex;
    if (gl_LocalInvocationIndex < ROWS && row < CELLS && rows[gl_LocalInvocationIndex] != 0u) {
        atomicMax(collapsed[CELLS + row], rows[gl_LocalInvocationIndex]);
    }
}
