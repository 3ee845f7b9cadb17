#version 460
#extension GL_GOOGLE_include_directive : require

// The fullest bin, of equally full ones the first. One workgroup.
layout(local_size_x = 256) in;
#define PLANE_BINDING 0
#include "methods/plane.glsl"
layout(std430, binding = 1) readonly buffer Bins { uint bins[]; };

shared uint counts[256];
shared uint picked[256];

void main() {
    uint local = gl_LocalInvocationIndex;
    uint bin = local, count = 0u;
    for (uint i = local; i < BINS; i += 256u) {
        uint n = bins[i];
        bin = n > count ? i : bin;
        count = max(n, count);
    }
    counts[local] = count;
    picked[local] = bin;
    barrier();
    for (uint width = 128u; width > 0u; width /= 2u) {
        if (local < width) {
            uint other = local + width;
            bool fuller = counts[other] > counts[local];
            if (fuller || counts[other] == counts[local] && picked[other] < picked[local]) {
                counts[local] = counts[other];
                picked[local] = picked[other];
            }
        }
        barrier();
    }
    if (local == 0u) {
        dominant.bin = picked[0];
        dominant.count = counts[0];
    }
}
