// Hard shadows whose edges run between texels. Needs receiver.glsl and the depths of casters:
//   vec4 caster_quad(uvec2 layers, vec2 low): at the texels low, low + (1, 0), low + (0, 1) and low + (1, 1)

// 1 lit, 0 shadowed. Each test of a texel is against the receiver's plane at its centre, so that a plane never shadows itself
// (book, 5.1.4). Where the four nearest tests differ, the edge is the line midway between the lit and the dark of the 4 x 4
// nearest texels, across the direction in which light increases; where no such line parts them, the contour at which the
// bilinear blend of the nearest four is one half.
float contour_visibility(Plane plane, uvec2 layers) {
    vec2 low = floor(plane.texel - 0.5);
    vec2 f = plane.texel - 0.5 - low;
    float first = plane.depth - dot(plane.slope, f);
    vec4 depths = vec4(first, first + plane.slope.x, first + plane.slope.y, first + plane.slope.x + plane.slope.y);
    vec4 lit = vec4(greaterThanEqual(depths, caster_quad(layers, low)));
    // loops that turn no time, not branches: some devices run both sides of those
    uint quads = any(notEqual(lit, lit.xxxx)) ? 4u : 0u;
    vec2 rise = vec2(0.0);
    uint tests = 0u;
    for (uint q = 0u; q < quads; q++) {
        vec2 side = 2.0 * vec2(q & 1u, q >> 1) - 1.0;
        vec4 here = vec4(greaterThanEqual(depths + dot(plane.slope, side), caster_quad(layers, low + side)));
        rise += 2.0 * side * dot(here, vec4(1.0)) + vec2(here.y + here.w - here.x - here.z, here.z + here.w - here.x - here.y);
        tests |= uint(dot(here, vec4(1.0, 2.0, 4.0, 8.0))) << (4u * q);
    }
    // places along `rise` from the middle of the 16, in halves of a texel
    float least_lit = 1e30;
    float most_dark = -1e30;
    for (uint q = 0u; q < quads; q++) {
        vec4 along = vec4(-rise.x - rise.y, rise.x - rise.y, rise.y - rise.x, rise.x + rise.y) + 2.0 * dot(rise, 2.0 * vec2(q & 1u, q >> 1) - 1.0);
        bvec4 here = notEqual(uvec4(tests >> (4u * q)) & uvec4(1u, 2u, 4u, 8u), uvec4(0u));
        vec4 high = mix(vec4(1e30), along, here);
        vec4 deep = mix(along, vec4(-1e30), here);
        least_lit = min(least_lit, min(min(high.x, high.y), min(high.z, high.w)));
        most_dark = max(most_dark, max(max(deep.x, deep.y), max(deep.z, deep.w)));
    }
    bool parted = quads > 0u && most_dark < least_lit;
    bool above = 2.0 * dot(rise, 2.0 * f - 1.0) > most_dark + least_lit;
    bool blend = dot(lit, vec4((1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y)) >= 0.5;
    return (parted ? above : blend) ? 1.0 : 0.0;
}
