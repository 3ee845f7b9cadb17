#version 460
#extension GL_GOOGLE_include_directive : require

// Vertices of a subdivided triangle, warped one by one.
layout(triangles, equal_spacing, cw) in;  // in the order of the corners: the domain's origin is its upper left
#define CELLS_CONSTANT 3
#define WARP_BINDING 6
#include "methods/rtw.glsl"
layout(location = 0) in vec2 in_uv[];
layout(location = 1) in vec4 in_color[];
layout(location = 2) in uint in_material[];
layout(location = 3) in uint in_mirrored[];
layout(location = 4) in vec3 in_place[];
layout(location = 0) out vec2 frag_uv;
layout(location = 1) out vec4 frag_color;
layout(location = 2) flat out uint material;
layout(location = 3) flat out uint mirrored;

void main() {
    vec3 share = gl_TessCoord;
    frag_uv = share.x * in_uv[0] + share.y * in_uv[1] + share.z * in_uv[2];
    frag_color = share.x * in_color[0] + share.y * in_color[1] + share.z * in_color[2];
    material = in_material[0];
    mirrored = in_mirrored[0];
    // on an edge one share is 0, and the sum of two products is the same in either order: neighbours have the same vertices
    precise vec3 place = share.x * in_place[0] + share.y * in_place[1] + share.z * in_place[2];
    gl_Position = vec4(2.0 * warped(place.xy) - 1.0, place.z, 1.0);
}
