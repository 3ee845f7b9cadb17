// Where one layer of a map lies: from t, coordinates across the light, divided by depth where the light has a position, to
// [0, 1]^2. The map may be projective, so that texels are smaller where the eye is near (perspective warping; book, 4.2), and then
// logarithmic along the second axis (book, 4.2.4).
struct Fit {
    vec4 row_u;  // u = (x * t.x + y * t.y + z) / w
    vec4 row_v;  // the same for v; of a logarithmic map as row_w
    vec4 row_w;  // w, 1 without a warp: it grows with the distance from the eye, and divides stored depths too
    vec4 texel;  // xy: size of the smallest texel along u and v; 0 where the layer holds no sample; z: 0, or v = z * log2(w)
};

bool logarithmic(Fit fit) { return fit.texel.z != 0.0; }

// Where the layer has a point, t.z being 1. It means something where w is above 0.
vec2 fit_place(Fit fit, vec3 t, out float w) {
    w = dot(fit.row_w.xyz, t);
    return vec2(dot(fit.row_u.xyz, t) / w, logarithmic(fit) ? fit.texel.z * log2(w) : dot(fit.row_v.xyz, t) / w);
}

// Change of (u, v), times `scale`, per change of t at a place of the map; the whole needs 1 / w in `scale`.
mat2 fit_change(Fit fit, vec2 uv, float scale) {
    vec2 v = logarithmic(fit) ? (1.44269504089 * fit.texel.z) * fit.row_w.xy : fit.row_v.xy - uv.y * fit.row_w.xy;
    return transpose(mat2(fit.row_u.xy - uv.x * fit.row_w.xy, v)) * scale;
}
