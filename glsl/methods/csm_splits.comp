#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/receiver.glsl"

// Practical splits (Zhang et al. 2006) between the nearest and the farthest visible sample.
layout(local_size_x = 1) in;
layout(constant_id = 0) const uint LAYERS = 1u;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
#define SLICES_BINDING 1
#include "methods/slices.glsl"
layout(push_constant) uniform Push { float lambda; };

void main() {
    float near = linear_depth(frame, uintBitsToFloat(extremes[0]));
    float far = linear_depth(frame, uintBitsToFloat(~extremes[1]));
    for (uint i = 0u; i <= LAYERS; i++) {
        float share = float(i) / float(LAYERS);
        splits[i] = mix(mix(near, far, share), near * pow(far / near, share), lambda);
    }
}
