// Finds the pages that bounds touch by walking down the quadtree. Needs `frame`, `counters`, `nodes`, PAGE_TEXELS and
// GUTTER, and two functions: `enter(node)` tells whether anything at or below a node matters, `visit(index, node)` gets
// each node whose page is touched and tells whether to stop.

#include "shared/caster_bounds.glsl"

void walk(vec2 low, vec2 high) {
    in_page_units(low, high);
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
        uint index = stack[--count];
        Node node = nodes[index];
        if (!enter(node)) {
            continue;
        }
        if (!page_missed(node.key, low, high) && visit(index, node)) {
            return;
        }
        // children are tested before they are loaded; their pages and all pages below lie within their border
        float side = power_of_two(key_level(node.key));
        vec2 corner = vec2(key_page(node.key)) * side;
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
