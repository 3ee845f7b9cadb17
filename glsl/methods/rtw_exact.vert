#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/structs.glsl"
#include "methods/fit.glsl"
#include "methods/map_place.glsl"

// Boxes around what triangles cover in the warped map.
#define CELLS_CONSTANT 3
#define WARP_BINDING 6
#include "methods/rtw.glsl"
#define FETCH_BINDING 8
#include "methods/bent_vertex.glsl"

void cover(vec3 a, vec3 b, vec3 c, out vec2 low, out vec2 high, out float nearest) {
    low = warped(min(min(a.xy, b.xy), c.xy));
    high = warped(max(max(a.xy, b.xy), c.xy));
    nearest = max(max(a.z, b.z), c.z);
}
