#version 460
#extension GL_GOOGLE_include_directive : require
#include "methods/fit.glsl"
#include "methods/quadtree.glsl"

// The quadtree at the start of a frame: where its tiles lie as seen from the eye, and nothing asked for yet; after a reset only
// the pages of the least depth, which are drawn.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint TILES = 1024u;
layout(std140, binding = 0) uniform VirtualBlock { VirtualMap map; };
layout(std430, binding = 1) writeonly buffer Cells { Cell cells[]; };
layout(std430, binding = 2) buffer TilePages { TilePage pages[]; };
layout(std430, binding = 3) writeonly buffer Fits { Fit fits[]; };
layout(std430, binding = 4) writeonly buffer Drawn { uint drawn[]; };

// Of no sample: everything falls outside.
const Fit NOWHERE = Fit(vec4(0.0, 0.0, 2.0, 0.0), vec4(0.0, 0.0, 2.0, 0.0), vec4(0.0, 0.0, 1.0, 0.0), vec4(0.0));

void main() {
    uint i = gl_GlobalInvocationID.x;
    bool root = i < root_count();
    if (map.reset == 1u && i < uint(cells.length())) {
        cells[i] = Cell(uint[4](0u, 0u, 0u, 0u), root ? i + 1u : 0u);
    }
    if (i >= TILES) {
        return;
    }
    TilePage page = pages[i];
    if (map.reset == 1u) {
        uint side = 1u << ROOT_DEPTH;
        page.depth = root ? ROOT_DEPTH : NO_PAGE;
        page.x = i % side;
        page.y = i / side;
        page.parent = 0u;
        page.used = 0u;
        page.value = 0u;
        page.seen = 0u;
    }
    // an edge is as wide as a few texels: without the page twice as many samples would lie on it. Samples are taken by turns,
    // so that one frame may see few of a page's
    page.value = max(2u * page.seen, page.value - (page.value + 7u) / 8u);
    page.seen = 0u;
    page.benefit = uint[4](0u, 0u, 0u, 0u);
    page.texels = uint[4](0u, 0u, 0u, 0u);
    pages[i] = page;
    fits[i] = page.depth == NO_PAGE ? NOWHERE : page_fit(map, page.depth, uvec2(page.x, page.y));
    drawn[i] = map.reset == 1u && root ? 1u : 0u;
}
