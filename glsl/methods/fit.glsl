// Where one layer of a map lies: from t, coordinates across the light, divided by depth where the light has a position, to
// [0, 1]^2. The map may be projective, so that texels are smaller where the eye is near (perspective warping; book, 4.2).
struct Fit {
    vec4 row_u;  // u = (x * t.x + y * t.y + z) / w
    vec4 row_v;
    vec4 row_w;  // w, 1 without a warp: it grows with the distance from the eye, and divides stored depths too
    vec4 texel;  // xy: size of the smallest texel along u and v; 0 where the layer holds no sample
};

// Change of (u, v), times `scale`, per change of t at a place of the map; the whole needs 1 / w in `scale`.
mat2 fit_change(Fit fit, vec2 uv, float scale) {
    return transpose(mat2(fit.row_u.xy - uv.x * fit.row_w.xy, fit.row_v.xy - uv.y * fit.row_w.xy)) * scale;
}
