#version 460
#extension GL_GOOGLE_include_directive : require
#include "methods/fit.glsl"
#include "methods/quadtree.glsl"
#include "methods/asm_counts.glsl"

// Makes the most profitable pages, and takes tiles for them (Fernando 2002, 2.4): free ones first, then those not used in the last
// frame, the least recently used first, then, where the new page gains more, those of least value. Only pages without
// children give up their tiles. The cell of a page has the index of its tile. One workgroup: a thread looks after every
// 256th tile and remembers its best offer.
layout(local_size_x = 256) in;
layout(constant_id = 0) const uint TILES = 1024u;
layout(std140, binding = 0) uniform VirtualBlock { VirtualMap map; };
layout(std430, binding = 1) coherent buffer Cells { Cell cells[]; };
layout(std430, binding = 2) coherent buffer TilePages { TilePage pages[]; };
layout(std430, binding = 3) writeonly buffer Fits { Fit fits[]; };
layout(std430, binding = 4) writeonly buffer Drawn { uint drawn[]; };
layout(std430, binding = 5) buffer Counts { AsmCounts counts; };
layout(push_constant) uniform Push {
    uint most;       // pages made in a frame
    uint threshold;  // samples that a quarter needs at least
    float overhead;  // cost of a page beside its texels, in tiles' worth of texels
};

// A page displaces another only if it gains this much more: counts differ from frame to frame.
const float MARGIN = 1.25;
const uint NONE = 0xffffffffu;

// Victims in order.
const uint FREE = 0u;
const uint UNUSED = 1u << 30;
const uint USED = 2u << 30;
const uint KEPT = 3u << 30;

shared uvec2 offers[256];   // bits of the benefit per cost, 4 * tile + quarter
shared uvec2 victims[256];  // class and age or value, tile
shared uvec2 touched;       // tiles whose places changed
shared uint parent_touched;
shared bool done;

bool childless(uint tile) {
    uint child[4] = cells[tile].child;
    return (child[0] | child[1] | child[2] | child[3]) == 0u;
}

// What a quarter's page would gain for its cost: the cost is that of the texels it needs to be as fine as the image, which are those
// of the pages below it too, and of the overhead. 0: not wanted.
float profit(TilePage page, uint tile, uint quarter) {
    uint benefit = page.benefit[quarter];
    if (page.depth == NO_PAGE || page.depth >= FINEST || benefit < threshold || benefit == 0u || cells[tile].child[quarter] != 0u) {
        return 0.0;
    }
    // the mean of the needed texels is their sum by the count; a quarter has a fourth of the page's
    precise float count = float(benefit);
    precise float cost = 0.25 * float(page.texels[quarter]);
    precise float fixed_cost = overhead * count;
    precise float ratio = count * count / (cost + fixed_cost);
    return ratio;
}

uvec2 victim_of(TilePage page, uint tile) {
    if (page.depth == NO_PAGE) {
        return uvec2(FREE, tile);
    }
    // what was made in this frame is kept
    if (page.parent == 0u || page.used == map.frame || !childless(tile)) {
        return uvec2(KEPT, tile);
    }
    return page.used + 1u < map.frame ? uvec2(UNUSED | page.used & 0x3fffffffu, tile) : uvec2(USED | min(page.value, 0x3fffffffu), tile);
}

bool better(uvec2 a, uvec2 b) { return a.x > b.x || a.x == b.x && a.y < b.y; }
bool sooner(uvec2 a, uvec2 b) { return a.x < b.x || a.x == b.x && a.y < b.y; }

void look(uint local) {
    uvec2 offer = uvec2(0u, NONE);
    uvec2 victim = uvec2(KEPT, NONE);
    for (uint tile = local; tile < TILES; tile += 256u) {
        TilePage page = pages[tile];
        for (uint quarter = 0u; quarter < 4u; quarter++) {
            uvec2 own = uvec2(floatBitsToUint(profit(page, tile, quarter)), 4u * tile + quarter);
            offer = better(own, offer) ? own : offer;
        }
        uvec2 own = victim_of(page, tile);
        victim = sooner(own, victim) ? own : victim;
    }
    offers[local] = offer;
    victims[local] = victim;
}

// Takes its tile from a page. The parent takes over what was said of it, so that it is not the next.
void evict(uint tile) {
    uint parent = pages[tile].parent - 1u;
    parent_touched = parent;
    for (uint quarter = 0u; quarter < 4u; quarter++) {
        if (cells[parent].child[quarter] == tile + 1u) {
            cells[parent].child[quarter] = 0u;
        }
    }
    pages[parent].used = max(pages[parent].used, pages[tile].used);
    pages[parent].value = max(pages[parent].value, pages[tile].value);
}

void make(uint tile, uint from, uint quarter) {
    TilePage page = pages[from];
    cells[from].child[quarter] = tile + 1u;
    cells[tile] = Cell(uint[4](0u, 0u, 0u, 0u), tile + 1u);
    uvec2 at = 2u * uvec2(page.x, page.y) + uvec2(quarter & 1u, quarter >> 1);
    uint value = page.benefit[quarter];
    page.depth++;
    page.x = at.x;
    page.y = at.y;
    page.parent = from + 1u;
    page.used = map.frame;
    page.value = value;
    page.seen = 0u;
    page.benefit = uint[4](0u, 0u, 0u, 0u);
    page.texels = uint[4](0u, 0u, 0u, 0u);
    pages[tile] = page;
    fits[tile] = page_fit(map, page.depth, at);
    drawn[tile] = 1u;
}

// Serves the best offer, if a tile can be had.
void serve(uvec2 offer, uvec2 victim) {
    uint from = offer.y / 4u, quarter = offer.y % 4u, tile = victim.y;
    touched = uvec2(from, tile);
    parent_touched = from;
    uint kind = victim.x & KEPT;
    bool gains = kind != USED || float(pages[from].benefit[quarter]) > MARGIN * float(victim.x & 0x3fffffffu) + 1.0;
    if (kind == KEPT || !gains || tile == from) {
        // the next may gain more
        pages[from].benefit[quarter] = 0u;
        return;
    }
    if (kind == FREE) {
        counts.resident++;
    } else {
        evict(tile);
        counts.evicted += kind == UNUSED ? 1u : 0u;
        counts.displaced += kind == USED ? 1u : 0u;
    }
    make(tile, from, quarter);
    counts.made++;
}

void main() {
    uint local = gl_LocalInvocationIndex;
    look(local);
    if (local == 0u) {
        counts.resident = map.reset == 1u ? root_count() : counts.resident;
        counts.made = 0u;
        counts.evicted = 0u;
        counts.displaced = 0u;
        counts.waiting = 0u;
        done = false;
    }
    barrier();
    // offers that are refused take their turn too
    for (uint turn = 0u; turn < 2u * most; turn++) {
        uvec2 offer = offers[local];
        uvec2 victim = victims[local];
        for (uint step = 128u; step > 0u; step /= 2u) {
            barrier();
            if (local < step) {
                offers[local] = better(offers[local + step], offers[local]) ? offers[local + step] : offers[local];
                victims[local] = sooner(victims[local + step], victims[local]) ? victims[local + step] : victims[local];
            }
            barrier();
        }
        if (local == 0u) {
            if (offers[0].x == 0u || counts.made >= most) {
                counts.waiting = offers[0].x != 0u ? 1u : 0u;
                done = true;
            } else {
                serve(offers[0], victims[0]);
            }
        }
        memoryBarrierBuffer();
        barrier();
        if (done) {
            break;
        }
        uvec3 changed = uvec3(touched, parent_touched) & 255u;
        bool own = any(equal(changed, uvec3(local)));
        barrier();
        offers[local] = offer;
        victims[local] = victim;
        if (own) {
            look(local);
        }
        barrier();
    }
}
