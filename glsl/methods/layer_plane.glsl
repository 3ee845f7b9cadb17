// Where a sample lies in a layer of a map, and its plane there. Needs fit.glsl, sample.glsl and receiver.glsl.

struct LayerPlace {
    vec3 ls;      // in the space of the layer's face
    float q;      // what divides stored depths
    vec2 texel;   // from the layer's corner
    mat2 along;   // change of the place across from a texel to the next, along u and along v
    vec2 size;    // of a texel, world units
    vec2 slope;   // change of z to the next texel in the receiver's plane
};

// False where the layer does not hold the sample. `side`: of the layer in texels.
bool place_in_layer(Fit fit, uint face, Sample s, float side, out LayerPlace p) {
    p.ls = light_space(face, s.from_eye);
    float w = divisor(p.ls.z);
    vec3 t = vec3(p.ls.xy / w, 1.0);
    p.q = dot(fit.row_w.xyz, t);
    vec2 uv = vec2(dot(fit.row_u.xyz, t), dot(fit.row_v.xyz, t)) / p.q;
    if (w <= 0.0 || p.q <= 0.0 || any(lessThan(uv, vec2(0.0))) || any(greaterThanEqual(uv, vec2(1.0)))) {
        return false;
    }
    vec3 normal = turned(face, s.normal);
    p.texel = uv * side;
    p.along = inverse(fit_change(fit, uv, side / p.q));
    p.size = w * vec2(length(p.along[0]), length(p.along[1]));
    // change of z per unit across, in the receiver's plane at constant x / w and y / w
    float facing = has_position() ? dot(normal, p.ls) : normal.z;
    vec2 across = clamp(-normal.xy * w / facing, -200.0, 200.0);
    p.slope = w * vec2(dot(across, p.along[0]), dot(across, p.along[1]));
    return true;
}

// With the bias of BIAS_PLANE.
Plane receiver_plane(Fit fit, LayerPlace p) {
    float bias = light.rule.x * receiver_bias(max(p.size.x, p.size.y), p.slope) + light.rule.y;
    // stored depth is affine over the receiver's plane
    float nearer = has_position() ? max(p.ls.z - bias, 1e-6 * p.ls.z) : p.ls.z - bias;
    float per_z = has_position() ? -light.depth.y / (p.ls.z * p.ls.z) : light.depth.x;
    float depth = stored_depth(nearer) / p.q;
    vec2 change = (p.slope * per_z - depth * vec2(dot(fit.row_w.xy, p.along[0]), dot(fit.row_w.xy, p.along[1]))) / p.q;
    return Plane(p.texel, depth, change, 0.0);
}
