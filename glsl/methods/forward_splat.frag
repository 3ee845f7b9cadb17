#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "methods/forward.glsl"

// Adds light to a pixel whose surface lies at the depth that the texel sees.
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(std430, binding = 5) readonly buffer Samples { ForwardSample samples[]; };
layout(std430, binding = 6) buffer Sums { uint sums[]; };
layout(location = 0) flat in ivec3 texel;
layout(location = 1) flat in float depth;

void main() {
    uvec2 pixel = uvec2(gl_FragCoord.xy);
    uint i = pixel.y * frame.size.x + pixel.x;
    ForwardSample s = samples[i];
    if (s.layer != uint(texel.z)) {
        return;
    }
    ivec2 away = place(s) - centre(texel.xy);
    uint light = weight(away.x) * weight(away.y);
    float on_plane = depth - depth_change(s, texel.xy);
    if (light > 0u && on_plane <= s.nearest && on_plane >= s.farthest) {
        atomicAdd(sums[i], light);
    }
}
