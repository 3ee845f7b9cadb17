// Finds the pages that a caster touches, by walking down the quadtrees of the faces that matter. Needs `counters`,
// `active_faces` (uint array), `roots` (uint array: table slot + 1 of each face's root), `nodes`, the page table, and what
// caster_bounds.glsl needs, and two functions: `enter(node)` tells whether anything at or below a node matters,
// `visit(index, node)` gets each node whose page is touched and tells whether to stop.

#include "shared/caster_bounds.glsl"

// Whether a visit told to stop.
bool walk_face(uint root, vec2 low, vec2 high) {
    // depth first; at most three siblings wait on each level
    uint stack[4 + 3 * ROOT_LEVEL];
    uint count = 1u;
    stack[0] = root;
    float border = float(GUTTER + 1u) / frame.rule.x;
    while (count > 0u) {
        uint index = stack[--count];
        Node node = nodes[index];
        if (!enter(node)) {
            continue;
        }
        uvec2 key = table_key(index);
        if (!page_missed(key, low, high) && visit(index, node)) {
            return true;
        }
        // children are tested before they are loaded; their pages and all pages below lie within their border
        float side = power_of_two(key_level(key));
        vec2 corner = vec2(key_page(key)) * side;
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
    return false;
}

// All faces that matter; `list`: 0 those with pages, 1 those with pages to draw.
void walk(uint list, Box box) {
    uint end = counters.active_faces[list];
    for (uint i = 0u; i < end; i++) {
        uint face = active_faces[list * FACE_CAPACITY + i];
        vec2 low, high;
        if (face_bounds(lights[face / FACES], face % FACES, box, low, high) && walk_face(roots[face] - 1u, low, high)) {
            return;
        }
    }
}
