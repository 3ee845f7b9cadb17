// How large the texels of a map look in the image: the columns of the Jacobian of the image against the map (book, 3.2.1).

// Of one pixel. A value above 1 is undersampling: that side of a texel is longer than a pixel.
struct SamplingError {
    float s;              // length of a texel's side along the map's first axis, in pixels
    float t;              // along its second
    float perspective_s;  // the same where the surface meets eye and light at equal angles (book, 3.2.3)
    float perspective_t;
    uint part;            // of the map; NO_PART where nothing looks up
};

const uint NO_PART = 0xffffffffu;

// Change per pixel to the right and down of where a plane through `ray * depth` is seen; its normal need not have unit length.
mat2x3 plane_steps(Frame frame, vec3 ray, float depth, vec3 normal) {
    float along = min(dot(normal, ray), -1e-6 * length(normal) * length(ray) - 1e-30);
    vec3 dx = frame.ray_dx.xyz, dy = frame.ray_dy.xyz;
    return mat2x3(depth * (dx - ray * (dot(normal, dx) / along)), depth * (dy - ray * (dot(normal, dy) / along)));
}

// The normal of a plane that the pixel's ray and the light's meet at equal angles: there is no projection error on it.
vec3 even_normal(vec3 ray, vec3 to_light) { return to_light - normalize(ray); }

// Lengths in pixels of a texel's sides from the change of place in the map, in texels, per pixel to the right and down.
vec2 texel_sides(vec2 dx, vec2 dy) {
    float area = max(abs(dx.x * dy.y - dx.y * dy.x), 1e-30);
    return min(vec2(length(vec2(dx.y, dy.y)), length(vec2(dx.x, dy.x))) / area, vec2(1e30));
}
