// Lists of samples by texel of a grid that is fitted to them (Johnson et al. 2005; Aila, Laine 2004): linked, so that no list has a
// longest length. Needs methods/light.glsl and methods/fit.glsl. Samples are numbered pixel by pixel. The includer defines
// IZB_BINDING, the first of three bindings, where it uses the lists.
layout(constant_id = 2) const uint SIDE = 64u;  // texels along a side of a layer's grid
#ifdef IZB_BINDING
layout(std430, binding = IZB_BINDING) buffer Heads { uint heads[]; };      // by layer, row and texel: the number of its first sample + 1, or 0
layout(std430, binding = IZB_BINDING + 1) buffer Listed { uvec4 listed[]; };  // by sample: place as bits of floats, next as in heads
layout(std430, binding = IZB_BINDING + 2) buffer Shadowed { uint shadowed[]; };  // by pixel: a bit for each sample that the light does not reach
#endif

// Place in a layer's grid, in texels times z.
vec3 grid_place(Fit fit, vec3 at) {
    vec3 t = vec3(at.xy, divisor(at.z));
    return vec3(float(SIDE) * vec2(dot(fit.row_u.xyz, t), dot(fit.row_v.xyz, t)), dot(fit.row_w.xyz, t));
}
