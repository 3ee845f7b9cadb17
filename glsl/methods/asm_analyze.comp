#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/receiver.glsl"
#include "methods/fit.glsl"
#include "methods/asm_samples.glsl"

// What finer pages would gain (Fernando 2002, 2.4): counts, of some of the pixels, those that lie at the edge of a shadow and have
// larger texels than pixels, for the quarter of the page that they lie in; and those that would miss the page they have.
layout(local_size_x = 8, local_size_y = 8) in;
layout(std430, binding = 7) buffer TilePages { TilePage pages[]; };
layout(std430, binding = 8) readonly buffer Fits { Fit fits[]; };
layout(binding = 9) uniform sampler2DArray map;
layout(push_constant) uniform Push {
    uvec2 step;    // pixels from one that is looked at to the next
    uvec2 offset;  // the first of them
};
#include "methods/place.glsl"
#include "methods/asm_edge.glsl"

// Most levels that the sum of needed texels counts: it cannot overflow.
const uint MOST_LACKED = 5u;

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy * step + offset;
    Served s;
    bool served = served_sample(pixel, s);
    uint tests = served && s.depth <= s.needed ? 9u : 0u;
    if (tests == 0u || !on_edge(s, tests)) {
        return;
    }
    atomicAdd(pages[s.tile].seen, 1u);
    if (s.depth < s.needed) {
        uint quarter = quarter_of(s.finest, s.depth);
        atomicAdd(pages[s.tile].benefit[quarter], 1u);
        atomicAdd(pages[s.tile].texels[quarter], 1u << 2u * min(s.needed - s.depth, MOST_LACKED));
    }
}
