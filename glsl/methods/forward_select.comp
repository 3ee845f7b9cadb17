#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "methods/fit.glsl"
#include "methods/forward.glsl"
#include "methods/forward_texel.glsl"

// Lists the blocks of texels of which at least one is in the view. Their order changes nothing.
layout(local_size_x = 8, local_size_y = 8) in;
layout(std430, binding = 4) buffer Splats {
    ForwardCounts counts;
    uint blocks[];  // there is room for all
};

shared uint in_view;

bool visible(ivec3 texel) {
    if (seen(texel) == 0.0) {
        return false;
    }
    Surfel s = surfel_of(texel);
    // sides of the view beyond which all corners lie
    bvec4 beyond = bvec4(true);
    bool behind = true;
    for (uint i = 0u; i < 4u; i++) {
        vec4 p = splat_corner(texel, s, vec2(i & 1u, i >> 1) * 2.0 - 1.0);
        bvec4 out_of = bvec4(p.x < -p.w, p.x > p.w, p.y < -p.w, p.y > p.w);
        beyond = bvec4(beyond.x && out_of.x, beyond.y && out_of.y, beyond.z && out_of.z, beyond.w && out_of.w);
        behind = behind && p.w <= 0.0;
    }
    return !behind && !any(beyond);
}

void main() {
    if (gl_LocalInvocationIndex == 0u) {
        in_view = 0u;
    }
    barrier();
    if (visible(ivec3(gl_GlobalInvocationID))) {
        atomicOr(in_view, 1u);
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u && in_view != 0u) {
        blocks[atomicAdd(counts.vertices, VERTICES) / VERTICES] = block_word(gl_WorkGroupID);
    }
}
