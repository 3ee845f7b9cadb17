#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/receiver.glsl"
#include "methods/fit.glsl"
#include "methods/sample.glsl"

// Puts the samples that the light shines on into the lists of the texels that they lie in.
layout(local_size_x = 8, local_size_y = 8) in;
layout(std430, binding = 5) readonly buffer Fits { Fit fits[]; };
#define IZB_BINDING 6
#include "methods/izb.glsl"
#include "methods/compared.glsl"

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, frame.size.xy))) {
        return;
    }
    uint own = pixel.y * frame.size.x + pixel.x;
    float depth = texelFetch(depth_image, ivec2(pixel), 0).r;
    Sample s = sample_at(pixel, depth);
    uint dark = 0u;
    bool shone = depth > 0.0 && shone_on(pixel, s);
    for (uint i = 0u; i < SAMPLES && depth > 0.0; i++) {
        // a light with a place may reach some of a pixel's samples
        Sample moved = s;
        if (shone && SAMPLES > 1u) {
            moved.from_eye = sample_point(i, pixel, depth, s);
        }
        if (!shone || SAMPLES > 1u && has_position() && !shone_on(pixel, moved)) {
            dark |= 1u << i;
            continue;
        }
        vec3 at = compared(face_of(s.layer), ray_start(moved.from_eye, s));
        vec3 place = grid_place(fits[s.layer], at);
        vec2 texel = place.xy / place.z;
        if (!(place.z > 0.0 && all(greaterThanEqual(texel, vec2(0.0))) && all(lessThan(texel, vec2(SIDE))))) {
            atomicAdd(outside, 1u);
            continue;
        }
        uint list = (s.layer * SIDE + uint(texel.y)) * SIDE + uint(texel.x);
        uint number = own * SAMPLES + i;
        listed[number] = uvec4(floatBitsToUint(at), atomicExchange(heads[list], number + 1u));
    }
    shadowed[own] = dark;
}
