#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/receiver.glsl"
#include "methods/fit.glsl"
#include "methods/sample.glsl"

// Decides a sample by the map where all texels around it agree, and lists a ray where they do not (Chan, Durand 2004; book, 2.4.7).
layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 2) const uint REACH = 1u;  // texels around the sample's
layout(std430, binding = 5) readonly buffer Fits { Fit fits[]; };
layout(binding = 6) uniform sampler2DArray map;
layout(binding = 7, r32ui) writeonly uniform uimage2DArray mask_image;  // floats; 0 where rays will tell
layout(std430, binding = 8) buffer RayCount { uint ray_count; };
layout(std430, binding = 9) writeonly buffer RayItems { uvec2 ray_items[]; };  // see exact_resolve.comp
layout(std430, binding = 10) writeonly buffer Rays { vec4 rays[]; };           // see exact_trace.glsl

#include "methods/place.glsl"

const uint ONE_RAY = 1u << 24;

// Whether no texel around the sample leaves a doubt. A surface that is no caster lies on the receiver's plane; what rises above it
// by less than the bias is not told from it by the map.
bool decided(Sample s, out float lit) {
    lit = 0.0;
    Place p;
    if (!place_of(0u, s, p) || p.steep) {
        return false;
    }
    Plane low = plane_of(p, fits[0], 0.0);
    Plane high = plane_of(p, fits[0], full_bias(p));
    bool all_lit = true, all_shadowed = true;
    int reach = int(REACH);
    ivec2 last = textureSize(map, 0).xy - 1;
    for (int y = -reach; y <= reach; y++) {
        for (int x = -reach; x <= reach; x++) {
            ivec2 texel = clamp(ivec2(p.texel) + ivec2(x, y), ivec2(0), last);
            float caster = texelFetch(map, ivec3(texel, 0), 0).r;
            all_lit = all_lit && depth_at(low, vec2(texel)) >= caster;
            all_shadowed = all_shadowed && depth_at(high, vec2(texel)) < caster;
        }
    }
    lit = all_lit ? 1.0 : 0.0;
    return all_lit || all_shadowed;
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, frame.size.xy))) {
        return;
    }
    float depth = texelFetch(depth_image, ivec2(pixel), 0).r;
    Sample s = sample_at(pixel, depth);
    float lit = 1.0;
    if (depth > 0.0) {
        lit = 0.0;
        if (shone_on(pixel, s) && !decided(s, lit)) {
            // there is room for a ray a pixel
            uint index = atomicAdd(ray_count, 1u);
            ray_items[index] = uvec2(pixel.x | pixel.y << 16, ONE_RAY);
            rays[2u * index] = vec4(s.from_eye, 1e30);
            rays[2u * index + 1u] = vec4(-light.faces[0].z.xyz, uintBitsToFloat(texelFetch(receiver_image, ivec2(pixel), 0).x));
        }
    }
    imageStore(mask_image, ivec3(pixel, 0), uvec4(floatBitsToUint(lit)));
}
