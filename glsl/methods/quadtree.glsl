// A quadtree of square pages over the plane across a parallel light. Depth d divides the virtual map into 2^d x 2^d pages; those of
// ROOT_DEPTH are always there, as the first cells, in rows. Pages stand in the world: their places follow from integers and
// from where the eye lies in a page of its own, so that lengths near the eye are exact. Needs fit.glsl; takes constants 11 to 14.
layout(constant_id = 11) const uint ROOT_DEPTH = 2u;
layout(constant_id = 12) const uint FINEST = 14u;  // greatest depth
layout(constant_id = 13) const uint SIDE = 128u;   // of a tile in texels, its border included
layout(constant_id = 14) const uint BORDER = 1u;  // texels around a page that its tile holds too

// Where the virtual map lies in a frame.
struct VirtualMap {
    ivec2 eye_page;   // page of FINEST that the eye is in
    vec2 eye_inside;  // place of the eye in it, 0 to 1
    float page;       // side of a page of FINEST, world units
    float square;     // squared side of a texel of depth 0, divided by 4^(levels by which pages are coarser than a pixel)
    uint rule;        // 0: pixels are measured by their area, 1: by their shorter side
    uint frame;       // number of the frame, from 2
    uint reset;       // 1 where nothing is kept of the frames before
};

// A node of the tree.
struct Cell {
    uint child[4];  // index + 1 of each quarter, bit 0 right, bit 1 lower; 0: none
    uint tile;      // the tile that holds it + 1; 0: none
};

// What a tile holds, from frame to frame.
struct TilePage {
    uint depth;       // NO_PAGE: the tile is free
    uint x;           // page of this depth
    uint y;
    uint parent;      // cell of the parent + 1; 0 at ROOT_DEPTH
    uint used;        // frame that last looked it up
    uint value;       // samples on edges that would miss it, as its parent would count them: the most of recent frames
    uint seen;        // samples on edges of its own in this frame that are not satisfied with less
    uint benefit[4];  // samples on edges for which the page is too coarse, in each quarter
    uint texels[4];   // sum over them of 4^(levels that they lack)
};

const uint NO_PAGE = 0xffffffffu;

// Pages as keys to sort, coarse ones first: depth, then column and row. No key's x is 0 but where the root is one page.
uvec2 page_key(uint depth, uvec2 page) { return uvec2(depth, page.x << 16 | page.y); }

uint root_count() { return 1u << 2u * ROOT_DEPTH; }

// Which quarter of its page of `depth` a page of FINEST lies in.
uint quarter_of(uvec2 finest, uint depth) {
    uvec2 bits = finest >> (FINEST - depth - 1u) & 1u;
    return bits.x | bits.y << 1;
}

// The page of FINEST that holds a place across the light relative to the eye; false outside the virtual map.
bool finest_page(VirtualMap map, vec2 across, out uvec2 page) {
    ivec2 at = map.eye_page + ivec2(floor(map.eye_inside + across / map.page));
    page = uvec2(at);
    return all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, ivec2(1 << FINEST)));
}

// Least depth whose texels are no larger than a pixel; `dx`, `dy`: change of place across the light from pixel to pixel. The areas
// are the thesis's measure (Fernando 2002, 2.4).
uint needed_depth(VirtualMap map, vec2 dx, vec2 dy) {
    float pixel = map.rule == 0u ? abs(dx.x * dy.y - dx.y * dy.x) : min(dot(dx, dx), dot(dy, dy));
    float depth = ceil(0.5 * log2(map.square / max(pixel, 1e-36)));
    return uint(clamp(depth, float(ROOT_DEPTH), float(FINEST)));
}

// Where the tile of a page lies.
Fit page_fit(VirtualMap map, uint depth, uvec2 page) {
    uint shift = FINEST - depth;
    float texel = map.page * float(1u << shift) / float(SIDE - 2u * BORDER);
    vec2 low = (vec2(ivec2(page << shift) - map.eye_page) - map.eye_inside) * map.page - float(BORDER) * texel;
    float scale = 1.0 / (texel * float(SIDE));
    return Fit(vec4(scale, 0.0, -low.x * scale, 0.0), vec4(0.0, scale, -low.y * scale, 0.0), vec4(0.0, 0.0, 1.0, 0.0), vec4(texel, texel, 0.0, 0.0));
}
