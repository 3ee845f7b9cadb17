#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/receiver.glsl"
#include "shared/structs.glsl"
#include "methods/fit.glsl"
#include "methods/asm_samples.glsl"

// Asks for the page of the depth that a sample needs, for every sample at the edge of a shadow whose tile is coarser (Lefohn et al.
// 2005). Threads whose neighbour in the workgroup asks for the same page say nothing; there is room for a request of each pixel.
layout(local_size_x = 8, local_size_y = 8) in;
layout(std430, binding = 7) readonly buffer TilePages { TilePage pages[]; };
layout(std430, binding = 8) readonly buffer Fits { Fit fits[]; };
layout(binding = 9) uniform sampler2DArray map;
layout(std430, binding = 10) buffer CountersBlock { Counters counters; };
layout(std430, binding = 11) writeonly buffer Keys { uvec2 keys[]; };
#include "methods/place.glsl"
#include "methods/asm_edge.glsl"

shared uvec2 asked[64];

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    Served s;
    bool served = served_sample(pixel, s);
    uint tests = served && s.depth < s.needed ? 9u : 0u;
    uvec2 key = uvec2(0u);
    if (tests > 0u && on_edge(s, tests)) {
        key = page_key(s.needed, s.finest >> (FINEST - s.needed));
    }
    uint local = gl_LocalInvocationIndex;
    asked[local] = key;
    barrier();
    bool left = local % 8u > 0u && asked[local - min(local, 1u)] == key;
    bool above = local >= 8u && asked[local - min(local, 8u)] == key;
    if (key.x != 0u && !left && !above) {
        keys[atomicAdd(counters.requests[0], 1u)] = key;
    }
}
