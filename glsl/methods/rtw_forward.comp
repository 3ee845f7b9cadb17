#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/receiver.glsl"
#include "methods/fit.glsl"
#include "methods/sample.glsl"
#include "methods/rtw_importance.glsl"

// Forward analysis (Rosen 2012, 4.1): the importance of what the light sees in a depth image of a texel a cell. With HYBRID only its
// shadow edges, which weigh what backward analysis found.
layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 2) const uint CELLS = 512u;
layout(constant_id = 3) const uint HYBRID = 0u;
layout(std430, binding = 5) readonly buffer Fits { Fit fits[]; };
layout(std430, binding = 6) buffer Importance { uint importance[]; };
layout(binding = 7) uniform sampler2DArray lit_depth;

// z along the light; where there is no caster, that of the farthest that can be.
float z_at(ivec2 cell) {
    ivec2 inside = clamp(cell, ivec2(0), ivec2(int(CELLS) - 1));
    return (texelFetch(lit_depth, ivec3(inside, 0), 0).r - light.depth.y) / light.depth.x;
}

// 5.3: by how much depth leaves a plane across the cell, in each of four directions, against the side of a cell. A slope is no edge.
float edge_importance(ivec2 cell, float z, float side) {
    const ivec2 STEPS[4] = ivec2[4](ivec2(1, 0), ivec2(0, 1), ivec2(1, 1), ivec2(1, -1));
    float most = 0.0;
    for (uint i = 0u; i < 4u; i++) {
        most = max(most, abs(z_at(cell + STEPS[i]) + z_at(cell - STEPS[i]) - 2.0 * z));
    }
    return most > side ? 1.0 : edge;
}

// The lesser of the changes to both sides, so that the one that crosses an edge does not count.
float change_along(ivec2 cell, ivec2 to, float z) {
    float after = z_at(cell + to) - z, before = z - z_at(cell - to);
    return abs(after) < abs(before) ? after : before;
}

void main() {
    ivec2 cell = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(uvec2(cell), uvec2(CELLS)))) {
        return;
    }
    uint at = uint(cell.y) * CELLS + uint(cell.x);
    Fit fit = fits[0];
    // across the light, along each axis of the map: a cell's step
    mat2 cells = inverse(transpose(mat2(fit.row_u.xy, fit.row_v.xy))) * (1.0 / float(CELLS));
    float side = max(length(cells[0]), length(cells[1]));
    float z = z_at(cell);
    float weight = edge < 1.0 ? edge_importance(cell, z, side) : 1.0;
    if (HYBRID != 0u) {
        importance[at] = floatBitsToUint(uintBitsToFloat(importance[at]) * weight);
        return;
    }
    vec2 across = cells * (vec2(cell) + 0.5 - vec2(fit.row_u.z, fit.row_v.z) * float(CELLS));
    vec3 ls = vec3(across, z) - vec3(light.faces[0].x.w, light.faces[0].y.w, light.faces[0].z.w);
    vec3 from_eye = ls.x * light.faces[0].x.xyz + ls.y * light.faces[0].y.xyz + ls.z * light.faces[0].z.xyz;
    vec4 clip = frame.clip_from_eye * vec4(from_eye, 1.0);
    // w is the depth along the view
    bool caster = texelFetch(lit_depth, ivec3(cell, 0), 0).r > 0.0;
    bool seen = caster && clip.w > 0.0 && all(lessThanEqual(abs(clip.xy), vec2(clip.w))) && nearness.x / clip.w > nearness.y;
    if (seen) {
        // the normal, turned to the light
        vec2 slope = vec2(change_along(cell, ivec2(1, 0), z), change_along(cell, ivec2(0, 1), z)) * inverse(cells);
        vec3 n = normalize(vec3(slope, -1.0));
        vec3 there = n.x * light.faces[0].x.xyz + n.y * light.faces[0].y.xyz + n.z * light.faces[0].z.xyz;
        weight *= seen_importance(from_eye, there, clip.w);
    } else {
        // 5.1
        weight *= view != 0u ? 0.0 : max(-nearness.y, LEAST);
    }
    importance[at] = floatBitsToUint(weight);
}
