// Debugging: the sampling error of each pixel in the layer of a fitted map that holds it. An includer whose texels are not those of the
// fit defines RESIZED, texels_of() and part_of().
#include "shared/frame.glsl"
#include "shared/receiver.glsl"
#include "shared/sampling.glsl"
#include "methods/fit.glsl"
#include "methods/sample.glsl"
#include "methods/tile.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 6) const uint TILES = 0u;  // 1: each sample's layer was picked
layout(std430, binding = 5) readonly buffer Fits { Fit fits[]; };
layout(std430, binding = 6) writeonly buffer Errors { SamplingError errors[]; };
layout(std430, binding = 7) readonly buffer Picked { uint picked[]; };  // with TILES
layout(push_constant) uniform Push { float side; };

// How many texels along u and along v stand in place of one of the fit, at a place of the map.
vec2 texels_of(vec2 uv);

// The part of the map that a place of a layer is in.
uint part_of(uint layer, vec2 uv);

#ifndef RESIZED
vec2 texels_of(vec2 uv) { return vec2(1.0); }
uint part_of(uint layer, vec2 uv) { return layer; }
#endif

// Sides of a texel on a plane through a point of a layer's light space. `change`: of texels per change of t.
vec2 sides(uint face, mat2 change, vec2 t, float w, mat2x3 steps) {
    vec2 moved[2];
    for (uint i = 0u; i < 2u; i++) {
        vec3 step = turned(face, steps[i]);
        moved[i] = change * (has_position() ? (step.xy - t * step.z) / w : step.xy);
    }
    return texel_sides(moved[0], moved[1]);
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, frame.size.xy))) {
        return;
    }
    SamplingError error = SamplingError(0.0, 0.0, 0.0, 0.0, NO_PART);
    float depth = texelFetch(depth_image, ivec2(pixel), 0).r;
    Sample s = sample_at(pixel, depth);
    bool reached = depth > 0.0 && shone_on(pixel, s);
    if (TILES == 1u) {
        s.layer = picked[pixel.y * frame.size.x + pixel.x];
    }
    if (reached && s.layer != NO_TILE) {
        uint face = face_of(s.layer);
        vec3 ls = light_space(face, s.from_eye);
        float w = divisor(ls.z);
        vec3 t = vec3(ls.xy / w, 1.0);
        Fit fit = fits[s.layer];
        float q;
        vec2 uv = fit_place(fit, t, q);
        if (w > 0.0 && q > 0.0 && all(greaterThanEqual(uv, vec2(0.0))) && all(lessThan(uv, vec2(1.0)))) {
            vec3 ray = pixel_ray(frame, pixel);
            mat3 axes = mat3(light.faces[face].x.xyz, light.faces[face].y.xyz, light.faces[face].z.xyz);
            vec3 to_light = has_position() ? -normalize(axes * ls) : -light.faces[face].z.xyz;
            vec2 texels = texels_of(uv);
            mat2 change = mat2(texels.x, 0.0, 0.0, texels.y) * fit_change(fit, uv, side / q);
            vec2 whole = sides(face, change, t.xy, w, plane_steps(frame, ray, depth, s.normal));
            vec2 perspective = sides(face, change, t.xy, w, plane_steps(frame, ray, depth, even_normal(ray, to_light)));
            error = SamplingError(whole.x, whole.y, perspective.x, perspective.y, part_of(s.layer, uv));
        }
    }
    errors[pixel.y * frame.size.x + pixel.x] = error;
}
