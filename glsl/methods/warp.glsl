// A perspective warp of a layer of a parallel light's map (book, 4.2): texels shrink towards a line across the light, `distance` before the
// nearest sample along `axis`. The includer declares fit.glsl and WARP_BINDING.
struct Warp {
    uint bounds[4];   // of the samples, across and along: the greatest negated coordinates, the greatest coordinates; ordered bits
    uint slopes[2];   // the same of across / along as seen from the line's middle
    uint depths[2];   // of the depths from the camera: the greatest complement, the greatest
    uint costs[2];    // sums over samples: sides of texels in pixels, of the map as it was fitted and of the warped one
    float middle;     // of the line, across
    float line;       // coordinate of the line along the axis
    float distance;   // from the line to the nearest sample
    float extent;     // of the samples along the axis
    uint warped;      // whether the warp serves
    uint through_eye; // whether depths grow along the axis from 0 at the eye, as on a side of the view frustum; `bounds` then hold across / along
    vec2 axis;        // unit vector across the light: the view direction as the light sees it, or the way in which depths grow on a side
    float sine;       // of the angle between view and light, 1 for a side; 0: no axis
    uint moved;       // whether the line of the rule met the samples and was moved before them
    Fit fit;
};

layout(std430, binding = WARP_BINDING) buffer Warps { Warp warps[]; };  // one for each layer

#include "methods/ordered.glsl"

const uint STEP_BOUNDS = 0u;
const uint STEP_SLOPES = 1u;
const uint STEP_COSTS = 2u;
