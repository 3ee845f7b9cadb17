#version 460
#extension GL_GOOGLE_include_directive : require
#include "methods/fit.glsl"

// Importance of each entry of the page table (Arvo 2004; book, 4.4.2), from a map of the whole root in layer 0: texels count the more
// the nearer their surface is to the viewer, and those at a jump of depth count by its height too.
layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 2) const uint TREE_LEVELS = 1u;
layout(constant_id = 3) const float BORDER = 1.0;  // texels
#define LIGHT_BINDING 0
#include "methods/light.glsl"
layout(std430, binding = 1) readonly buffer Fits { Fit fits[]; };
layout(binding = 2) uniform sampler2DArray map;
layout(std430, binding = 3) writeonly buffer Requests { uint importance[]; };  // at most MOST each, so that sums fit a word
layout(push_constant) uniform Push {
    float near;    // distance from the viewer below which nothing counts more
    float jumps;   // weight of a jump of a texel's height
};

const float MOST = 65535.0;
const float HIGHEST = 16.0;  // jump in texels beyond which nothing counts more

float z_at(ivec2 texel) {
    ivec2 last = textureSize(map, 0).xy - 1;
    return (texelFetch(map, ivec3(clamp(texel, ivec2(0), last), 0), 0).r - light.depth.y) / light.depth.x;
}

void main() {
    uvec2 entry = gl_GlobalInvocationID.xy;
    uint entries = 1u << TREE_LEVELS;
    if (any(greaterThanEqual(entry, uvec2(entries)))) {
        return;
    }
    float side = float(textureSize(map, 0).x);
    Fit fit = fits[0];
    mat2 across = inverse(transpose(mat2(fit.row_u.xy, fit.row_v.xy)));
    float texel_size = max(fit.texel.x, fit.texel.y);
    float inner = side - 2.0 * BORDER;
    ivec2 first = ivec2(BORDER + inner * vec2(entry) / float(entries));
    ivec2 end = max(ivec2(BORDER + inner * vec2(entry + 1u) / float(entries)), first + 1);
    float sum = 0.0;
    for (int y = first.y; y < end.y; y++) {
        for (int x = first.x; x < end.x; x++) {
            float z = z_at(ivec2(x, y));
            // what a plane does not explain
            float jump = 0.0;
            for (int axis = 0; axis < 2; axis++) {
                ivec2 next = axis == 0 ? ivec2(1, 0) : ivec2(0, 1);
                jump = max(jump, abs(z_at(ivec2(x, y) + next) - 2.0 * z + z_at(ivec2(x, y) - next)));
            }
            vec2 t = across * ((vec2(x, y) + 0.5) / side - vec2(fit.row_u.z, fit.row_v.z));
            float distance = max(length(vec3(t, z - light.faces[0].z.w)), near) / near;
            sum += (1.0 + jumps * min(jump / texel_size, HIGHEST)) / (distance * distance);
        }
    }
    // a mean, so that entries with a texel more count no more
    float mean = sum / float((end.x - first.x) * (end.y - first.y));
    importance[entry.y << TREE_LEVELS | entry.x] = uint(clamp(mean / (1.0 + jumps * HIGHEST) * MOST, 1.0, MOST));
}
