// Finds the pages that a caster touches by walking down the quadtree. Needs `frame`, `nodes`, `pages`, `casters`,
// `clusters`, `instances`, `counters` and the constants PAGE_TEXELS and GUTTER; calls `visit(page, caster)`.

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

bool caster_misses(uint key, vec2 low, vec2 high) {
    int level = key_level(key);
    ivec2 corner = frame.anchor_page.xy + (ivec2(key_page(key)) << level);
    vec2 origin = vec2(corner) * frame.page.x;
    float scale = frame.rule.w * frame.page.y * exp2(-float(level));
    return misses((low - origin) * scale + float(GUTTER), (high - origin) * scale + float(GUTTER), texel_margin(level));
}

void visit_pages(uint index) {
    Caster caster = casters[index];
    vec2 low, high;
    caster_bounds(caster, low, high);
    // depth first: at most three siblings wait on each level
    uint stack[4 + 3 * ROOT_LEVEL];
    uint count = 0u;
    for (uint r = 0u; r < 4u; r++) {
        if (counters.roots[r] != 0u) {
            stack[count++] = counters.roots[r] - 1u;
        }
    }
    while (count > 0u) {
        Node node = nodes[stack[--count]];
        // subtrees of a page are tested with that page's texels: whatever covers a centre of a finer page is larger
        int level = key_level(node.key);
        ivec2 corner = frame.anchor_page.xy + (ivec2(key_page(node.key)) << level);
        float side = frame.page.x * exp2(float(level));
        vec2 origin = vec2(corner) * frame.page.x;
        vec2 border = vec2(side * (float(GUTTER + 1u) / frame.rule.w) + 0.01 * frame.page.x);
        if (any(greaterThan(low, origin + side + border)) || any(lessThan(high, origin - border))) {
            continue;
        }
        if (node.page != 0u && !caster_misses(node.key, low, high)) {
            visit(node.page - 1u, index);
        }
        for (uint q = 0u; q < 4u; q++) {
            if (node.child[q] != 0u && node.rank >= counters.threshold) {
                stack[count++] = node.child[q] - 1u;
            }
        }
    }
}
