// Where an instance stands in a page, to more than single precision: fine pages of large worlds are smaller than what that
// leaves of world coordinates. Needs structs.glsl and light.glsl. No device needs fused or double arithmetic for it.

// A sum and what single precision leaves of it (Knuth).
vec2 two_sum(float a, float b) {
    precise float sum = a + b;
    precise float part = sum - a;
    precise float rest = (a - (sum - part)) + (b - part);
    return vec2(sum, rest);
}

// A product and what single precision leaves of it (Dekker 1971).
vec2 two_product(float a, float b) {
    precise float product = a * b;
    precise float a_scaled = 4097.0 * a;
    precise float a_high = a_scaled - (a_scaled - a);
    precise float a_low = a - a_high;
    precise float b_scaled = 4097.0 * b;
    precise float b_high = b_scaled - (b_scaled - b);
    precise float b_low = b - b_high;
    precise float rest = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low;
    return vec2(product, rest);
}

// (axis + axis_low) . (high + low) - from, where only the result is rounded.
float along(vec3 axis, vec3 axis_low, vec3 high, vec3 low, float from) {
    vec2 x = two_product(axis.x, high.x), y = two_product(axis.y, high.y), z = two_product(axis.z, high.z);
    vec2 xy = two_sum(x.x, y.x);
    vec2 xyz = two_sum(xy.x, z.x);
    precise float rest = ((x.y + y.y) + (z.y + xy.y)) + (xyz.y + (dot(axis, low) + dot(axis_low, high)));
    precise float result = (xyz.x - from) + rest;
    return result;
}

// The zero of the instance's mesh space in light axes, world units: of a directional light relative to the page's origin and
// to the farthest depth, otherwise relative to the light.
vec3 page_anchor(Light light, Page page, Instance instance) {
    vec3 high = vec3(instance.rows[0].w, instance.rows[1].w, instance.rows[2].w);
    vec3 low = instance.low.xyz;
    if (light.kind.x != LIGHT_DIRECTIONAL) {
        precise vec3 from_light = (high - light.place.xyz) + (low - light.place_low.xyz);
        return light_axes(light, from_light);
    }
    return vec3(
        along(light.axis_x.xyz, light.low_x.xyz, high, low, page.origin.x),
        along(light.axis_y.xyz, light.low_y.xyz, high, low, page.origin.y),
        along(light.axis_z.xyz, vec3(0.0), high, low, light.scale.w)
    );
}
