#version 460
#extension GL_GOOGLE_include_directive : require
#include "methods/fit.glsl"

// Chooses the line of each layer's warp, then fits the warped map to its samples, then decides whether it serves.
layout(local_size_x = 1) in;
layout(constant_id = 0) const uint RULE = 0u;  // RULE_*
layout(constant_id = 1) const uint LOGARITHM = 0u;  // 1: the warped map is logarithmic along the axis
#define WARP_BINDING 0
#include "methods/warp.glsl"
layout(std430, binding = 1) buffer Fits { Fit fits[]; };
layout(push_constant) uniform Push {
    uint step;         // STEP_* whose measures are there
    float resolution;
    float border;      // texels
    float parameter;   // of the rule
    uint always;       // 1: the warp serves even where it gains nothing
};

const uint RULE_LISPSM = 0u;  // the distance that spreads the error evenly (book, 4.17)
const uint RULE_PSM = 1u;     // the line passes through the eye
const uint RULE_TSM = 2u;     // the nearest `parameter` of the samples' extent gets four fifths of the map (Martin, Tan 2004)
const uint RULE_GIVEN = 3u;   // `parameter`, world units
const uint RULE_DEPTH = 4u;   // where depth from the eye falls to 0, if it grows evenly over the samples' extent
const uint RULE_PLANE = 5u;   // line and middle are there: plane_line.comp

Warp warp;  // of the layer

void choose_line() {
    vec2 low = -vec2(unordered(warp.bounds[0]), unordered(warp.bounds[1]));
    vec2 high = vec2(unordered(warp.bounds[2]), unordered(warp.bounds[3]));
    float extent = high.y - low.y;
    // depths as the axis has them
    float near = warp.through_eye == 1u ? max(low.y, 0.0) : uintBitsToFloat(~warp.depths[0]);
    float distance = parameter;
    float middle = 0.5 * (low.x + high.x);
    if (RULE == RULE_LISPSM) {
        distance = (near + sqrt(near * (near + extent * warp.sine))) / warp.sine;
    } else if (RULE == RULE_PSM) {
        distance = low.y;
        middle = 0.0;
    } else if (RULE == RULE_TSM) {
        distance = extent * 0.2 * parameter / (0.8 - parameter);
    } else if (RULE == RULE_DEPTH) {
        distance = extent * near / max(uintBitsToFloat(warp.depths[1]) - near, 1e-6 * near);
        middle = 0.0;
    } else if (RULE == RULE_PLANE) {
        distance = low.y - warp.line;
        middle = warp.middle;
    }
    if (LOGARITHM == 1u) {
        // a line farther away changes texels by less than an eighth, and rounding would take the rest
        distance = min(distance, 8.0 * extent);
    }
    // no closer: nothing may lie on the line
    float least = 1e-3 * extent;
    warp.moved = distance < least ? 1u : 0u;
    warp.distance = max(distance, least);
    warp.line = low.y - warp.distance;
    // a side widens from the eye: on the line where its middle comes from
    warp.middle = warp.through_eye == 1u ? warp.line * middle : middle;
    warp.extent = extent;
}

// Rows of the map from across and along to [0, 1]^2: across over along, and what along has of the share of the map, or its logarithm
// (Lloyd et al. 2008; book, 4.31).
void fit_warp() {
    float n = warp.distance;
    vec2 slopes = vec2(-unordered(warp.slopes[0]), unordered(warp.slopes[1]));
    float grown = resolution / (resolution - 2.0 * border);
    float run = LOGARITHM == 1u ? log(1.0 + warp.extent / n) : warp.extent / (n + warp.extent);
    vec2 size = max(vec2(slopes.y - slopes.x, run), vec2(1e-6)) * grown;
    vec2 low = 0.5 * (vec2(slopes.x + slopes.y, run) - size);
    // w is 2 at the nearest sample, so that it is above 1 in the border too: stored depths stay below 1. Logarithms begin where w is 1
    float unit = (LOGARITHM == 1u ? exp(-low.y) : 2.0) / n;
    vec3 across = vec3(warp.axis.y, -warp.axis.x, -warp.middle) * unit;
    vec3 along = vec3(warp.axis, -warp.line) * unit;
    warp.fit.row_w = vec4(along, 0.0);
    warp.fit.row_u = vec4((across - low.x * along) / size.x, 0.0);
    warp.fit.texel = vec4(size * n / resolution, 0.0, 0.0);
    if (LOGARITHM == 1u) {
        warp.fit.row_v = warp.fit.row_w;
        warp.fit.texel.z = log(2.0) / size.y;
    } else {
        // the way from the nearest sample over along
        vec3 from_nearest = vec3(warp.axis, unordered(warp.bounds[1])) * unit;
        warp.fit.row_v = vec4((from_nearest - low.y * along) / size.y, 0.0);
    }
}

void main() {
    uint layer = gl_WorkGroupID.x;
    warp = warps[layer];
    // without samples, or with a light along the view, there is no axis
    if (warp.bounds[0] == 0u || warp.sine < 1e-3) {
        return;
    }
    if (step == STEP_BOUNDS) {
        choose_line();
    } else if (step == STEP_SLOPES) {
        fit_warp();
    } else if (always == 1u || warp.costs[1] < warp.costs[0]) {
        warp.warped = 1u;
        fits[layer] = warp.fit;
    }
    warps[layer] = warp;
}
