#version 460
#extension GL_GOOGLE_include_directive : require

// The warp that has the camera's perspective on a plane. On the plane depth from the eye is an affine function of the place across the
// light: its gradient is the warp's axis, and the line lies where it is 0. Texels then are of one size in the image of the plane.
layout(local_size_x = 1) in;
layout(constant_id = 2) const uint AUTO = 0u;  // 1: the plane of the samples that were summed up, 0: the one given
#define LIGHT_BINDING 0
#include "methods/light.glsl"
#define PLANE_BINDING 1
#include "methods/plane.glsl"
#include "methods/fit.glsl"
#define WARP_BINDING 2
#include "methods/warp.glsl"

vec4 mean_plane() {
    vec4 mean;
    for (uint i = 0u; i < 4u; i++) {
        float sum = float(dominant.sums[2u * i + 1u]) * 4294967296.0 + float(dominant.sums[2u * i]);
        mean[i] = sum / (UNIT * float(max(dominant.count, 1u)));
    }
    // the normals of a bin are at most a quarter apart along each axis: their mean has a length
    return vec4(normalize(mean.xyz - 1.0), -mean.w * bin_offset(dominant.bin));
}

void main() {
    if (AUTO == 1u) {
        if (dominant.count == 0u) {
            return;
        }
        dominant.plane = mean_plane();
    }
    vec3 normal = dominant.plane.xyz, forward = dominant.forward.xyz;
    float offset = dominant.plane.w;
    // the line at depth 0 of the plane runs along the horizon; across and along it the image is upright
    vec3 horizon = cross(normal, forward);
    vec3 n = turned(0u, normal), f = turned(0u, forward);
    // light along the plane, a plane through the eye or across the view: no line
    if (abs(n.z) < 1e-3 || offset == 0.0 || dot(horizon, horizon) < 1e-6) {
        return;
    }
    vec2 gradient = f.xy - n.xy * (f.z / n.z);
    float steepness = length(gradient);
    if (steepness < 1e-3) {
        return;
    }
    vec2 axis = gradient / steepness;
    // the point of the line that is nearest to the eye
    vec3 nearest = (offset / dot(horizon, horizon)) * (normal - forward * dot(normal, forward));
    warps[0].axis = axis;
    warps[0].line = -offset * (f.z / n.z) / steepness;
    warps[0].middle = dot(vec2(axis.y, -axis.x), turned(0u, nearest).xy);
    warps[0].sine = 1.0;
}
