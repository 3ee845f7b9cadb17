#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/split.glsl"
#include "methods/fit.glsl"
#include "methods/izb_casters.glsl"
#include "methods/izb.glsl"
#include "methods/compared.glsl"
#include "methods/corner.glsl"

// Casters over the grid of samples, conservatively: a triangle that covers every texel that the caster touches (Hasselgren,
// Akenine-Moeller, Ohlsson 2005; book, 4.5.1). It may cover more, which costs time but changes nothing. Vertices are fetched here,
// since each needs the others of its triangle.
layout(location = 0) flat out vec3 corner_a;  // in the space of `compared`
layout(location = 1) flat out vec3 corner_b;
layout(location = 2) flat out vec3 corner_c;
layout(location = 3) flat out uint instance_index;
layout(location = 4) flat out uint triangle;

// A triangle is widened by this many texels: half a texel's diagonal, so that a texel that it touches anywhere has its centre
// inside; and a sixteenth of a texel along both axes, to which vertices may be rounded.
const float WIDER = 0.8;
// Triangles that reach farther than this many grids are not widened edge by edge, which rounding would not bear.
const float FAR = 8.0;

float cross2(vec2 a, vec2 b) { return a.x * b.y - a.y * b.x; }

// Corner `k` of a right-angled triangle that covers a rectangle.
vec2 of_rectangle(vec2 low, vec2 size, uint k) { return low + 2.0 * size * vec2(k == 1u, k == 2u); }

// Corner `k` of the triangle that covers a caster, in texels: the smallest of three. All casters that are not left out meet the
// rectangle of the grid.
vec2 covering(vec2 p[3], vec2 low, vec2 high, uint k) {
    vec2 edges[3] = vec2[3](p[1] - p[0], p[2] - p[1], p[0] - p[2]);
    vec3 lengths = vec3(length(edges[0]), length(edges[1]), length(edges[2]));
    float longest = max(max(lengths.x, lengths.y), lengths.z);
    vec2 size = high - low;
    float box = 2.0 * size.x * size.y;
    vec2 corner = of_rectangle(low, size, k);
    if (!(longest <= FAR * float(SIDE))) {
        return corner;
    }
    // the rectangle along the longest edge
    vec2 axis = longest == lengths.x ? edges[0] : longest == lengths.y ? edges[1] : edges[2];
    axis = longest > 0.0 ? axis / longest : vec2(1.0, 0.0);
    vec2 turned_low = vec2(0.0), turned_high = vec2(0.0);
    for (uint i = 1u; i < 3u; i++) {
        vec2 d = p[i] - p[0];
        vec2 t = vec2(dot(axis, d), cross2(axis, d));
        turned_low = min(turned_low, t);
        turned_high = max(turned_high, t);
    }
    turned_low -= WIDER;
    vec2 turned_size = turned_high + WIDER - turned_low;
    float least = 2.0 * turned_size.x * turned_size.y;
    if (least < box) {
        vec2 t = of_rectangle(turned_low, turned_size, k);
        corner = p[0] + t.x * axis + t.y * vec2(-axis.y, axis.x);
    } else {
        least = box;
    }
    // the caster itself with its edges moved outwards
    float twice = abs(cross2(edges[0], edges[2]));
    float around = lengths.x + lengths.y + lengths.z;
    if (0.5 * twice + WIDER * around + WIDER * WIDER * around * around / (2.0 * twice) < least) {
        vec2 a = normalize(p[(k + 1u) % 3u] - p[k]), b = normalize(p[(k + 2u) % 3u] - p[k]);
        corner = p[k] - (a + b) * (WIDER / abs(cross2(a, b)));
    }
    return corner;
}

void main() {
    Instance instance = instances[gl_InstanceIndex];
    triangle = uint(gl_VertexIndex) / 3u;
    instance_index = uint(gl_InstanceIndex);
    uvec3 vertices = uvec3(indices[3u * triangle], indices[3u * triangle + 1u], indices[3u * triangle + 2u]);
    corner_a = corner_at(face_of(LAYER), instance, vertices.x);
    corner_b = corner_at(face_of(LAYER), instance, vertices.y);
    corner_c = corner_at(face_of(LAYER), instance, vertices.z);
    Fit fit = fits[LAYER];
    vec3 at[3] = vec3[3](corner_a, corner_b, corner_c);
    vec2 p[3];
    // how far each corner is inside the sides of the grid, where the light's place is in one line with them
    vec4 inside = vec4(-1e-30);
    bool before = false, behind = true;
    for (uint i = 0u; i < 3u; i++) {
        vec3 place = grid_place(fit, at[i]);
        vec4 sides = vec4(place.xy, float(SIDE) * place.z - place.xy);
        inside = max(inside, sides + WIDER * abs(place.z));
        before = before || !(place.z > 1e-4 * length(at[i]));
        behind = behind && place.z <= 0.0;
        p[i] = place.xy / place.z;
    }
    vec2 low = vec2(0.0), high = vec2(SIDE);
    bool out_of_sight = (instance.flags & 3u) == POLICY_NEVER;
    if (has_position() && before) {
        // it passes the light: no rectangle holds it
        out_of_sight = out_of_sight || behind || any(lessThan(inside, vec4(0.0)));
        p[0] = vec2(-1e30);
        p[1] = vec2(1e30);
    } else {
        low = max(min(min(p[0], p[1]), p[2]) - WIDER, low);
        high = min(max(max(p[0], p[1]), p[2]) + WIDER, high);
        out_of_sight = out_of_sight || any(lessThan(high, low));
    }
    vec2 texel = covering(p, low, high, uint(gl_VertexIndex) % 3u);
    gl_Position = out_of_sight ? vec4(0.0, 0.0, 0.0, 1.0) : vec4(2.0 / float(SIDE) * texel - 1.0, 0.5, 1.0);
}
