#version 460
#extension GL_GOOGLE_include_directive : require

// Subdivides a triangle so that none of its edges is longer in the warped map than a share of the map's side (Rosen 2012, 6.1).
layout(vertices = 3) out;
#define CELLS_CONSTANT 3
#define WARP_BINDING 6
#include "methods/rtw.glsl"
layout(constant_id = 4) const float LONGEST = 0.025;  // share of the map's side
layout(location = 0) in vec2 in_uv[];
layout(location = 1) in vec4 in_color[];
layout(location = 2) flat in uint in_material[];
layout(location = 3) flat in uint in_mirrored[];
layout(location = 4) in vec3 in_place[];
layout(location = 0) out vec2 out_uv[];
layout(location = 1) out vec4 out_color[];
layout(location = 2) out uint out_material[];
layout(location = 3) out uint out_mirrored[];
layout(location = 4) out vec3 out_place[];

// Parts of an edge; the same from both sides of it.
float parts(uint a, uint b) {
    precise vec2 along = abs(warped(in_place[a].xy) - warped(in_place[b].xy));
    return clamp(ceil(length(along) / LONGEST), 1.0, float(gl_MaxTessGenLevel));
}

void main() {
    out_uv[gl_InvocationID] = in_uv[gl_InvocationID];
    out_color[gl_InvocationID] = in_color[gl_InvocationID];
    out_material[gl_InvocationID] = in_material[gl_InvocationID];
    out_mirrored[gl_InvocationID] = in_mirrored[gl_InvocationID];
    out_place[gl_InvocationID] = in_place[gl_InvocationID];
    if (gl_InvocationID == 0) {
        // an outer level is that of the edge across from a corner
        vec3 outer = vec3(parts(1u, 2u), parts(2u, 0u), parts(0u, 1u));
        vec2 low = min(min(in_place[0].xy, in_place[1].xy), in_place[2].xy);
        vec2 high = max(max(in_place[0].xy, in_place[1].xy), in_place[2].xy);
        if (any(lessThan(high, vec2(0.0))) || any(greaterThan(low, vec2(1.0)))) {
            outer = vec3(0.0);  // beside the map: dropped
        }
        gl_TessLevelOuter[0] = outer.x;
        gl_TessLevelOuter[1] = outer.y;
        gl_TessLevelOuter[2] = outer.z;
        gl_TessLevelInner[0] = max(outer.x, max(outer.y, outer.z));
    }
}
