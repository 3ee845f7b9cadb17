#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/receiver.glsl"
#include "methods/fit.glsl"
#include "methods/sample.glsl"

// What the visible samples that the light shines on ask for (Giegl, Wimmer 2007a; book, 4.4.2): for each entry of the page table, how
// many need which level along u and along v, so that no texel is wider than the box around a pixel's footprint.
// A thread walks down 32 pixels of a column, and adds neighbours that ask for the same at once.
layout(local_size_x = 64) in;
layout(constant_id = 6) const uint TREE_LEVELS = 1u;
layout(constant_id = 7) const uint BINS = 1u;  // levels told apart, the last: finer than there is; 1: samples are only counted
layout(std430, binding = 5) readonly buffer Root { Fit root; };
layout(std430, binding = 6) buffer Requests { uint requests[]; };  // for u, then for v: for each level: of each entry
layout(push_constant) uniform Push {
    float texels;   // of a tile along a side that samples may fall on
    float density;  // texels along the footprint of a pixel
};

const uint ROWS = 32u;

// Least level whose texels are small enough, for footprints of these extents.
uvec2 levels_of(vec2 extent) {
    vec2 level = ceil(log2(density / max(extent * texels, vec2(1e-30))));
    return uvec2(clamp(level, vec2(0.0), vec2(BINS - 1u)));
}

void add(uint entry, uvec2 levels, uint count) {
    if (count == 0u) {
        return;
    }
    atomicAdd(requests[(levels.x << 2u * TREE_LEVELS) + entry], count);
    if (BINS > 1u) {
        atomicAdd(requests[(BINS + levels.y << 2u * TREE_LEVELS) + entry], count);
    }
}

void main() {
    uint last_entry = 0u, count = 0u;
    uvec2 last_levels = uvec2(0u);
    for (uint r = 0u; r < ROWS; r++) {
        uvec2 pixel = uvec2(gl_GlobalInvocationID.x, gl_WorkGroupID.y * ROWS + r);
        float depth = all(lessThan(pixel, frame.size.xy)) ? texelFetch(depth_image, ivec2(pixel), 0).r : 0.0;
        Sample s = sample_at(pixel, depth);
        if (depth <= 0.0 || !shone_on(pixel, s)) {
            continue;
        }
        vec3 t = vec3(light_space(0u, s.from_eye).xy, 1.0);
        vec2 uv = vec2(dot(root.row_u.xyz, t), dot(root.row_v.xyz, t));
        float side = float(1u << TREE_LEVELS);
        uvec2 at = uvec2(clamp(uv * side, vec2(0.0), vec2(side - 1.0)));
        uint entry = at.y << TREE_LEVELS | at.x;
        uvec2 levels = uvec2(0u);
        if (BINS > 1u) {
            vec3 dx, dy;
            decode_derivatives(frame, texelFetch(receiver_image, ivec2(pixel), 0), depth, dx, dy);
            vec2 a = turned(0u, dx).xy, b = turned(0u, dy).xy;
            levels = levels_of(vec2(abs(dot(root.row_u.xy, a)) + abs(dot(root.row_u.xy, b)), abs(dot(root.row_v.xy, a)) + abs(dot(root.row_v.xy, b))));
        }
        if (entry != last_entry || levels != last_levels) {
            add(last_entry, last_levels, count);
            last_entry = entry;
            last_levels = levels;
            count = 0u;
        }
        count++;
    }
    add(last_entry, last_levels, count);
}
