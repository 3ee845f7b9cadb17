#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/structs.glsl"
#include "methods/fit.glsl"
#include "methods/map_place.glsl"

// Boxes around what triangles cover in a logarithmic perspective map (Lloyd et al. 2008; book, 4.2.4). A corner is (u w, w), which runs
// evenly over the plane across the light, on both sides of the line where w is 0.
#define FETCH_BINDING 6
#include "methods/bent_vertex.glsl"

// Widens a box by a point of the triangle. `rounding`: of the point's first coordinate.
void hold(vec3 corner, float w, float rounding, inout vec2 low, inout vec2 high, inout float nearest) {
    vec2 at = vec2(corner.x / w, logarithmic(fits[0]) ? fits[0].texel.z * log2(w) : corner.y);
    low = min(low, at - vec2(rounding, 0.0));
    high = max(high, at + vec2(rounding, 0.0));
    nearest = max(nearest, corner.z / w);
}

void cover(vec3 a, vec3 b, vec3 c, out vec2 low, out vec2 high, out float nearest) {
    vec3 corners[3] = vec3[3](a, b, c);
    low = vec2(1e30);
    high = vec2(-1e30);
    nearest = 0.0;
    for (uint i = 0u; i < 3u; i++) {
        vec3 p = corners[i], q = corners[(i + 1u) % 3u];
        if (!logarithmic(fits[0])) {
            hold(p, 1.0, 0.0, low, high, nearest);
            continue;
        }
        // the map begins where w is 1: what lies before that or behind the line is cut off
        if (p.y >= 1.0) {
            hold(p, p.y, 0.0, low, high, nearest);
        }
        if (p.y >= 1.0 != q.y >= 1.0) {
            vec3 cut = mix(p, q, (p.y - 1.0) / (p.y - q.y));
            hold(cut, 1.0, 1e-6 * max(abs(p.x), abs(q.x)), low, high, nearest);
        }
    }
}
