#version 460
#extension GL_GOOGLE_include_directive : require
#include "methods/fit.glsl"
#include "methods/quadtree.glsl"
#include "methods/asm_gpu_counts.glsl"

// Makes the way in the tree to each new page, and places its tile. Cells on the way may be made by any of the threads that need
// them; a cell that was made in vain stays empty. There are as many as all ways together could need.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint TILES = 1024u;
layout(std140, binding = 0) uniform VirtualBlock { VirtualMap map; };
layout(std430, binding = 1) coherent buffer Cells { Cell cells[]; };
layout(std430, binding = 2) readonly buffer TilePages { TilePage pages[]; };
layout(std430, binding = 3) writeonly buffer Fits { Fit fits[]; };
layout(std430, binding = 4) readonly buffer Drawn { uint drawn[]; };
layout(std430, binding = 5) buffer Counts { AsmGpuCounts counts; };

void main() {
    uint tile = gl_GlobalInvocationID.x;
    if (tile >= TILES || drawn[tile] == 0u) {
        return;
    }
    uint depth = pages[tile].depth;
    uvec2 page = uvec2(pages[tile].x, pages[tile].y);
    uvec2 finest = page << (FINEST - depth);
    uvec2 root = finest >> (FINEST - ROOT_DEPTH);
    uint at = (root.y << ROOT_DEPTH) + root.x;
    for (uint d = ROOT_DEPTH; d < depth; d++) {
        uint quarter = quarter_of(finest, d);
        uint next = cells[at].child[quarter];
        if (next == 0u) {
            uint made = atomicAdd(counts.cells, 1u) + 1u;
            uint won = atomicCompSwap(cells[at].child[quarter], 0u, made);
            next = won == 0u ? made : won;
        }
        at = next - 1u;
    }
    cells[at].tile = tile + 1u;
    fits[tile] = page_fit(map, depth, page);
}
