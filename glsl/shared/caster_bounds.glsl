// Bounds of casters across the light and what they cover. Needs `frame`, PAGE_TEXELS and GUTTER. Everything is `precise`:
// passes that must agree on which page a caster touches give the same bits whatever the compiler makes of each.

// Bounds in light space of a box in mesh space.
void caster_bounds(Instance instance, vec3 middle, vec3 extent, out precise vec2 low, out precise vec2 high) {
    vec4 center = vec4(middle, 1.0);
    precise vec3 p = vec3(dot(instance.rows[0], center), dot(instance.rows[1], center), dot(instance.rows[2], center));
    precise vec3 along_x = frame.light_x.x * instance.rows[0].xyz + frame.light_x.y * instance.rows[1].xyz + frame.light_x.z * instance.rows[2].xyz;
    precise vec3 along_y = frame.light_y.x * instance.rows[0].xyz + frame.light_y.y * instance.rows[1].xyz + frame.light_y.z * instance.rows[2].xyz;
    precise vec2 c = vec2(dot(frame.light_x.xyz, p), dot(frame.light_y.xyz, p));
    precise vec2 e = vec2(dot(abs(along_x), extent), dot(abs(along_y), extent));
    low = c - e;
    high = c + e;
}

void cluster_bounds(Instance instance, Cluster cluster, out vec2 low, out vec2 high) {
    vec3 center = vec3(cluster.center[0], cluster.center[1], cluster.center[2]);
    caster_bounds(instance, center, vec3(cluster.extent[0], cluster.extent[1], cluster.extent[2]), low, high);
}

void mesh_bounds(Instance instance, MeshBounds mesh, out vec2 low, out vec2 high) {
    vec3 center = vec3(mesh.center[0], mesh.center[1], mesh.center[2]);
    caster_bounds(instance, center, vec3(mesh.extent[0], mesh.extent[1], mesh.extent[2]), low, high);
}

// Rounding of light-space coordinates reaches a quarter of a texel at level 0; the rasteriser snaps to 1/256.
float texel_margin(int level) { return 1.0 / 64.0 + 0.25 * power_of_two(-level); }

// Whether bounds in texels of a page cover no texel centre of the page.
bool misses(vec2 low, vec2 high, float margin) {
    precise vec2 first = max(ceil(low - 0.5 - margin), vec2(0.0));
    precise vec2 last = min(floor(high - 0.5 + margin), vec2(float(PAGE_TEXELS - 1u)));
    return any(greaterThan(first, last));
}

// From light space to sides of a level-0 page relative to the anchor, widened by the rounding of the former.
void in_page_units(inout precise vec2 low, inout precise vec2 high) {
    low = low * frame.page.y - vec2(frame.anchor_page.xy) - 0.01;
    high = high * frame.page.y - vec2(frame.anchor_page.xy) + 0.01;
}

// Whether bounds in level-0 pages cover no texel centre of a page.
bool page_missed(uint key, vec2 low, vec2 high) {
    int level = key_level(key);
    float side = power_of_two(level);
    vec2 corner = vec2(key_page(key)) * side;
    precise float texels = frame.rule.w / side;
    precise vec2 from = (low - corner) * texels + float(GUTTER);
    precise vec2 to = (high - corner) * texels + float(GUTTER);
    return misses(from, to, texel_margin(level));
}
