// Samples of a pixel other than its middle: they lie on the plane of its surface. Needs SAMPLES, how many there are, and BEND,
// the share of the way from the middle by which the surface may rise above that plane: samples are moved so far towards the light
// that it does not shadow itself, for no more than the way.

// Part of a sample's way from the middle of its pixel by which it is moved towards the light. `way`: in which light travels.
float towards_light(vec3 way, vec3 n) { return BEND / max(-dot(n, way), BEND); }

// A side of a pixel on the receiver's plane: not lifted off it by rounding, and where the plane is seen edge-on no longer than
// the way to the eye.
vec3 pixel_side(vec3 from_eye, vec3 n, vec3 d) {
    d -= n * dot(n, d);
    return d * min(1.0, length(from_eye) / max(length(d), 1e-30));
}

// `sample_places` of src/config.rs: Hammersley's points, no two in a row or a column. They are the same in all pixels: turned
// ones would trade steps that follow an edge for noise.
vec2 sample_place(uint i) {
    float least = 0.5 / float(SAMPLES) - 0.5;
    return vec2(float(i) / float(SAMPLES), float(bitfieldReverse(i)) / 4294967296.0) + least;
}

// `light`: the direction in which the light travels where it is parallel, else the eye relative to its place.
vec3 sub_sample(uint i, bool parallel, vec3 light, vec3 from_eye, vec3 n, vec3 side_x, vec3 side_y) {
    if (SAMPLES == 1u) {
        return from_eye;
    }
    vec2 place = sample_place(i);
    vec3 shift = place.x * side_x + place.y * side_y;
    vec3 at = from_eye + shift;
    vec3 q = at + light;
    float move = length(shift) * towards_light(parallel ? light : normalize(q), n);
    return at - (parallel ? move * light : q * min(move / length(q), 0.5));
}
