// Where a sample lies in a layer of a map, and how its plane runs there. Needs receiver.glsl, fit.glsl, sample.glsl, `fits` and
// `map`. An includer whose texels are not all alike defines PLACED and placed().
struct Place {
    vec3 ls;      // light space
    float q;      // what divides stored depths
    vec2 texel;   // from the layer's corner
    vec2 in_plane;  // the same, for the way to the middles of texels
    mat2 along;   // change of t from a texel to the next, along u and along v
    vec2 size;    // of a texel, world units
    vec2 slope;   // change of z to the next texel in the receiver's plane
    bool steep;   // the plane is steeper than `slope` says
};

// A point of a layer among the texels of the map, from `at`, where the fit has it. `in_plane`: as in Place; `span`: sides of its
// texel in those of the fit.
vec2 placed(Fit fit, vec2 at, float side, out vec2 in_plane, out vec2 span);

#ifndef PLACED
vec2 placed(Fit fit, vec2 at, float side, out vec2 in_plane, out vec2 span) {
    in_plane = at;
    span = vec2(1.0);
    if (logarithmic(fit)) {
        // stored depths run evenly over 1 / w: the way to the middle of the texel is that of 1 / w, in texels here
        float doubling = fit.texel.z * side, middle = floor(at.y) + 0.5;
        in_plane.y = middle - 1.44269504089 * doubling * (1.0 - exp2((at.y - middle) / doubling));
    }
    return at;
}
#endif

// False where the layer does not hold the sample.
bool place_of(uint layer, Sample s, out Place p) {
    uint face = face_of(layer);
    p.ls = light_space(face, s.from_eye);
    float w = divisor(p.ls.z);
    vec3 t = vec3(p.ls.xy / w, 1.0);
    Fit fit = fits[layer];
    vec2 uv = fit_place(fit, t, p.q);
    if (w <= 0.0 || p.q <= 0.0 || any(lessThan(uv, vec2(0.0))) || any(greaterThanEqual(uv, vec2(1.0)))) {
        return false;
    }
    vec3 normal = turned(face, s.normal);
    float side = float(textureSize(map, 0).x);
    vec2 span;
    p.texel = placed(fit, uv * side, side, p.in_plane, span);
    p.along = inverse(fit_change(fit, uv, side / p.q));
    p.along[0] *= span.x;
    p.along[1] *= span.y;
    p.size = w * vec2(length(p.along[0]), length(p.along[1]));
    // change of z per unit across, in the receiver's plane at constant x / w and y / w
    float facing = has_position() ? dot(normal, p.ls) : normal.z;
    vec2 across = -normal.xy * w / facing;
    p.steep = any(greaterThan(abs(across), vec2(200.0)));
    across = clamp(across, -200.0, 200.0);
    p.slope = w * vec2(dot(across, p.along[0]), dot(across, p.along[1]));
    return true;
}

// The bias that the settings ask for, world units; beside it comes the rounding, light.rule.y.
float full_bias(Place p) { return light.rule.x * receiver_bias(max(p.size.x, p.size.y), p.slope); }

// Stored depth over the receiver's plane, nearer to the light by `bias` and by the rounding: it is affine.
Plane plane_of(Place p, Fit fit, float bias) {
    bias += light.rule.y;
    float nearer = has_position() ? max(p.ls.z - bias, 1e-6 * p.ls.z) : p.ls.z - bias;
    float per_z = has_position() ? -light.depth.y / (p.ls.z * p.ls.z) : light.depth.x;
    float depth = stored_depth(nearer) / p.q;
    vec2 change = (p.slope * per_z - depth * vec2(dot(fit.row_w.xy, p.along[0]), dot(fit.row_w.xy, p.along[1]))) / p.q;
    return Plane(p.in_plane, depth, change, 0.0);
}

// At the middle of the texel with this corner.
float depth_at(Plane plane, vec2 low) { return plane.depth + dot(plane.slope, low + 0.5 - plane.texel); }
