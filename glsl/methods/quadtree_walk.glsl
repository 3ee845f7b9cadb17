// The way down a quadtree. Needs quadtree.glsl and `cells`.

// The deepest page on the way to a page of FINEST that has a tile, and its cell and depth; no deeper than `most`.
uint deepest_tile(uvec2 finest, uint most, out uint cell, out uint depth) {
    uvec2 root = finest >> (FINEST - ROOT_DEPTH);
    uint at = (root.y << ROOT_DEPTH) + root.x;
    uint tile = cells[at].tile;
    cell = at;
    depth = ROOT_DEPTH;
    for (uint d = ROOT_DEPTH; d < most; d++) {
        uint next = cells[at].child[quarter_of(finest, d)];
        if (next == 0u) {
            break;
        }
        at = next - 1u;
        if (cells[at].tile != 0u) {
            tile = cells[at].tile;
            cell = at;
            depth = d + 1u;
        }
    }
    return tile - 1u;
}
