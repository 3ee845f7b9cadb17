// Whether a sample lies at the edge of a shadow in its tile. Needs asm_samples.glsl and place.glsl.

// Whether the 3 x 3 texels around the sample part into those that its plane is lit by and those that shadow it: the thesis's pixels
// that straddle a depth discontinuity (Fernando 2002, 2.4), as far as the discontinuity matters to the receiver.
// `tests`: 9, or 0 where nobody asks; a loop that turns no time, as some devices run both sides of branches.
bool on_edge(Served s, uint tests) {
    Place p;
    uint count = place_of(s.tile, s.at, p) ? tests : 0u;
    Plane plane = plane_of(p, fits[s.tile], full_bias(p));
    vec2 low = clamp(floor(plane.texel) - 1.0, vec2(0.0), vec2(float(SIDE) - 3.0));
    uint lit = 0u;
    for (uint i = 0u; i < count; i++) {
        vec2 texel = low + vec2(i % 3u, i / 3u);
        lit += depth_at(plane, texel) >= texelFetch(map, ivec3(ivec2(texel), s.tile), 0).r ? 1u : 0u;
    }
    return lit > 0u && lit < count;
}
