#version 460
#extension GL_GOOGLE_include_directive : require
#define PLACED
#include "methods/map_lookup.glsl"

// Through a rectilinear warp (Rosen 2012, 4.4). The plane is compared at a texel's centre as it lies without the warp; a kernel takes
// the texels around for as large.
#define CELLS_CONSTANT 11
#define WARP_BINDING 12
#include "methods/rtw.glsl"
layout(constant_id = 12) const uint SIDE = 2048u;
#define CENTRES_BINDING 13
#include "methods/rtw_centres.glsl"

vec2 placed(Fit fit, vec2 at, float side, out vec2 in_plane, out vec2 span) {
    // what lies in cells without importance at the far end comes to the end of the map
    vec2 texel = min(warped(at / side) * side, vec2(side * (1.0 - 6e-8)));
    uvec2 low = uvec2(texel);
    vec2 u = centres[low.x], v = centres[SIDE + low.y];
    span = vec2(u.y, v.y) * side;
    in_plane = floor(texel) + 0.5 + (at - vec2(u.x, v.x) * side) / span;
    return texel;
}
