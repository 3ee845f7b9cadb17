#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"

// Gives the selected pages, now in the order of their keys, their layer of the atlas and their place in light space.
layout(local_size_x = 256) in;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(std430, binding = 1) readonly buffer CountersBlock { Counters counters; };
layout(std430, binding = 2) buffer Nodes { Node nodes[]; };
layout(std430, binding = 3) readonly buffer Keys { uint keys[]; };
layout(std430, binding = 4) readonly buffer Values { uint values[]; };
layout(std430, binding = 5) writeonly buffer Pages { Page pages[]; };
layout(std430, binding = 6) writeonly buffer PairCounts { uint pair_counts[]; };

void main() {
    for (uint i = gl_GlobalInvocationID.x; i < counters.sorted; i += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
        uint key = keys[i];
        int level = key_level(key);
        // exact: an integer below 2^24 times a power of two
        ivec2 corner = frame.anchor_page.xy + (ivec2(key_page(key)) << level);
        vec2 origin = vec2(corner) * frame.page.x;
        float scale = frame.rule.w * frame.page.y * exp2(-float(level));
        pages[i] = Page(key, i, values[i], 0u, origin, scale, 0u);
        nodes[values[i]].page = i + 1u;
        pair_counts[2u * i] = 0u;
        pair_counts[2u * i + 1u] = 0u;
    }
}
