// Whether casters may touch a tile. Needs light.glsl, fit.glsl and structs.glsl. For parallel light and maps without a warp.

// `center`, `extent`: a box in mesh space. `side`: of the tile in texels.
bool touches(Fit fit, Instance instance, vec3 center, vec3 extent, float side) {
    vec4 middle = vec4(center, 1.0);
    vec3 world = vec3(dot(instance.rows[0], middle), dot(instance.rows[1], middle), dot(instance.rows[2], middle));
    vec2 t = light_space(0u, world - light.eye.xyz).xy;
    vec2 reach = vec2(0.0);
    for (int i = 0; i < 3; i++) {
        vec2 axis = turned(0u, vec3(instance.rows[0][i], instance.rows[1][i], instance.rows[2][i]) * extent[i]).xy;
        reach += abs(vec2(dot(fit.row_u.xy, axis), dot(fit.row_v.xy, axis)));
    }
    vec2 uv = vec2(dot(fit.row_u.xyz, vec3(t, 1.0)), dot(fit.row_v.xyz, vec3(t, 1.0)));
    // rounding, of the products that make up uv too
    vec2 size = vec2(dot(abs(fit.row_u.xy), abs(t)), dot(abs(fit.row_v.xy), abs(t))) + abs(vec2(fit.row_u.z, fit.row_v.z));
    vec2 slack = reach + 1.0 / side + 1e-6 * size;
    return all(greaterThanEqual(uv, -slack)) && all(lessThanEqual(uv, 1.0 + slack));
}
