// Bounds of casters and what they cover. Needs `frame`, `clusters`, `instances` and PAGE_TEXELS.

// Bounds of a caster across the light, in light space.
void caster_bounds(Caster caster, out vec2 low, out vec2 high) {
    Cluster cluster = clusters[caster.cluster];
    Instance instance = instances[caster.instance];
    vec4 center = vec4(cluster.center[0], cluster.center[1], cluster.center[2], 1.0);
    vec3 extent = vec3(cluster.extent[0], cluster.extent[1], cluster.extent[2]);
    vec3 p = vec3(dot(instance.rows[0], center), dot(instance.rows[1], center), dot(instance.rows[2], center));
    vec3 along_x = frame.light_x.x * instance.rows[0].xyz + frame.light_x.y * instance.rows[1].xyz + frame.light_x.z * instance.rows[2].xyz;
    vec3 along_y = frame.light_y.x * instance.rows[0].xyz + frame.light_y.y * instance.rows[1].xyz + frame.light_y.z * instance.rows[2].xyz;
    vec2 c = vec2(dot(frame.light_x.xyz, p), dot(frame.light_y.xyz, p));
    vec2 e = vec2(dot(abs(along_x), extent), dot(abs(along_y), extent));
    low = c - e;
    high = c + e;
}

// Rounding of light-space coordinates reaches a quarter of a texel at level 0; the rasteriser snaps to 1/256.
float texel_margin(int level) { return 1.0 / 64.0 + 0.25 * exp2(-float(level)); }

// Whether bounds in texels of a page cover no texel centre of the page.
bool misses(vec2 low, vec2 high, float margin) {
    vec2 first = max(ceil(low - 0.5 - margin), vec2(0.0));
    vec2 last = min(floor(high - 0.5 + margin), vec2(float(PAGE_TEXELS - 1u)));
    return any(greaterThan(first, last));
}
