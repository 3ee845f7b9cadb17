#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "methods/fit.glsl"
#include "methods/forward.glsl"
#include "methods/forward_texel.glsl"

// A quad for each texel of the listed blocks: the square of the kernel on the plane of the surface that the texel sees.
layout(std430, binding = 4) readonly buffer Splats {
    ForwardCounts counts;
    uint blocks[];
};
layout(location = 0) flat out ivec3 texel;
layout(location = 1) flat out float depth;

void main() {
    const uint CORNERS[6] = uint[](0u, 1u, 2u, 2u, 1u, 3u);
    uint vertex = uint(gl_VertexIndex);
    uvec3 block = block_of(blocks[vertex / VERTICES]);
    uint within = vertex % VERTICES / 6u;
    texel = ivec3(BLOCK * block.xy + uvec2(within % BLOCK, within / BLOCK), block.z);
    depth = seen(texel);
    gl_Position = vec4(0.0, 0.0, 0.0, 1.0);  // all six: no triangle
    if (depth > 0.0) {
        uint corner = CORNERS[vertex % 6u];
        gl_Position = splat_corner(texel, surfel_of(texel), vec2(corner & 1u, corner >> 1) * 2.0 - 1.0);
    }
}
