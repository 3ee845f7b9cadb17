#version 460
#extension GL_GOOGLE_include_directive : require
#include "methods/map_lookup.glsl"

// Through a rectilinear warp (Rosen 2012, 4.4). The plane is compared at a texel's centre as it lies without the warp; a kernel takes
// the texels around for as large.
#define CELLS_CONSTANT 7
#define WARP_BINDING 10
#include "methods/rtw.glsl"
layout(constant_id = 8) const uint SIDE = 2048u;
#define CENTRES_BINDING 11
#include "methods/rtw_centres.glsl"

Place placed(vec2 uv, float side) {
    // what lies in cells without importance at the far end comes to the end of the map
    vec2 texel = min(warped(uv) * side, vec2(side * (1.0 - 6e-8)));
    uvec2 at = uvec2(texel);
    vec2 u = centres[at.x], v = centres[SIDE + at.y];
    return Place(texel, vec2(u.x, v.x) * side, vec2(u.y, v.y) * side);
}
