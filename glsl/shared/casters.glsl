// Finds the pages that a caster touches by walking down the quadtree. Needs `frame`, `nodes`, `pages`, `casters`,
// `clusters`, `instances`, `counters` and the constants PAGE_TEXELS and GUTTER; calls `visit(page, caster)`.

#include "shared/caster_bounds.glsl"

void visit_pages(uint index) {
    vec2 low, high;
    caster_bounds(casters[index], low, high);
    // in level-0 pages relative to the anchor, widened by the rounding of light-space coordinates
    low = low * frame.page.y - vec2(frame.anchor_page.xy) - 0.01;
    high = high * frame.page.y - vec2(frame.anchor_page.xy) + 0.01;
    // depth first; at most three siblings wait on each level
    uint stack[4 + 3 * ROOT_LEVEL];
    uint count = 0u;
    float border = float(GUTTER + 1u) / frame.rule.w;
    for (uint r = 0u; r < 4u; r++) {
        if (counters.roots[r] != 0u) {
            stack[count++] = counters.roots[r] - 1u;
        }
    }
    while (count > 0u) {
        Node node = nodes[stack[--count]];
        int level = key_level(node.key);
        float side = exp2(float(level));
        vec2 corner = vec2(key_page(node.key)) * side;
        if (node.page != 0u) {
            float texels = frame.rule.w / side;
            if (!misses((low - corner) * texels + float(GUTTER), (high - corner) * texels + float(GUTTER), texel_margin(level))) {
                visit(node.page - 1u, index);
            }
        }
        if (node.rank >= counters.threshold) {
            // children are tested before they are loaded; their pages and all pages below lie within their border
            float half_side = 0.5 * side;
            float reach = border * half_side;
            bvec2 first = bvec2(low.x <= corner.x + half_side + reach, low.y <= corner.y + half_side + reach);
            bvec2 second = bvec2(high.x >= corner.x + half_side - reach, high.y >= corner.y + half_side - reach);
            bvec2 inside_low = bvec2(high.x >= corner.x - reach, high.y >= corner.y - reach);
            bvec2 inside_high = bvec2(low.x <= corner.x + side + reach, low.y <= corner.y + side + reach);
            for (uint q = 0u; q < 4u; q++) {
                bool x = (q & 1u) == 0u ? first.x && inside_low.x : second.x && inside_high.x;
                bool y = (q & 2u) == 0u ? first.y && inside_low.y : second.y && inside_high.y;
                if (x && y && node.child[q] != 0u) {
                    stack[count++] = node.child[q] - 1u;
                }
            }
        }
    }
}
