#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/receiver.glsl"
#include "methods/fit.glsl"
#include "methods/sample.glsl"
#include "methods/forward.glsl"

// Where the map has the surface under each pixel, and which depths match it; an empty sum of light.
layout(local_size_x = 8, local_size_y = 8) in;
layout(std430, binding = 5) readonly buffer Fits { Fit fits[]; };
layout(binding = 6) uniform sampler2DArray map;
layout(std430, binding = 7) writeonly buffer Samples { ForwardSample samples[]; };
layout(std430, binding = 8) writeonly buffer Sums { uint sums[]; };

#include "methods/place.glsl"

bool in_layer(uint layer, Sample s, inout ForwardSample found) {
    Place p;
    if (!place_of(layer, s, p)) {
        return false;
    }
    float bias = full_bias(p);
    Plane near = plane_of(p, fits[layer], bias);
    // rounding is added to the bias: on the far side it counts the other way
    Plane far = plane_of(p, fits[layer], -bias - 2.0 * light.rule.y);
    ivec2 at = ivec2(floor(p.texel * 256.0));
    vec2 rounded = vec2(at) / 256.0 - p.texel;
    found = ForwardSample(at.x, at.y, near.depth + dot(near.slope, rounded), far.depth + dot(near.slope, rounded),
                          near.slope.x, near.slope.y, layer, 0u);
    return true;
}

ForwardSample found(uvec2 pixel) {
    ForwardSample found = ForwardSample(0, 0, 0.0, 0.0, 0.0, 0.0, NO_SURFACE, 0u);
    float depth = texelFetch(depth_image, ivec2(pixel), 0).r;
    if (depth <= 0.0) {
        return found;
    }
    Sample s = sample_at(pixel, depth);
    if (!shone_on(pixel, s)) {
        found.layer = UNLIT;
        return found;
    }
    if (in_layer(s.layer, s, found)) {
        return found;
    }
    atomicAdd(outside, 1u);
    found.layer = OUTSIDE;
    for (uint layer = 0u; layer < LAYERS && found.layer == OUTSIDE; layer++) {
        in_layer(layer, s, found);
    }
    return found;
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (all(lessThan(pixel, frame.size.xy))) {
        uint i = pixel.y * frame.size.x + pixel.x;
        samples[i] = found(pixel);
        sums[i] = 0u;
    }
}
