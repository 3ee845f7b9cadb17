#version 460
#extension GL_GOOGLE_include_directive : require

// Practical splits (Zhang et al. 2006) between the nearest and the farthest visible sample.
layout(local_size_x = 1) in;
layout(constant_id = 0) const uint LAYERS = 1u;
#define SLICES_BINDING 0
#include "methods/slices.glsl"
layout(push_constant) uniform Push { float lambda; };

void main() {
    float near = uintBitsToFloat(~extremes[1]);
    float far = uintBitsToFloat(extremes[0]);
    for (uint i = 0u; i <= LAYERS; i++) {
        float share = float(i) / float(LAYERS);
        splits[i] = mix(mix(near, far, share), near * pow(far / near, share), lambda);
    }
}
