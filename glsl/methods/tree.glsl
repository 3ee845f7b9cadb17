// A tree of tiles over the root of a map: rectangles of entries of a page table of 2^LEVELS by 2^LEVELS entries, in a list for each
// round of refinement. The includer defines TREE_LEVELS and TREE_TILES, the room in a list.
struct Region {
    uvec2 low;        // first entry
    uvec2 size;       // entries along u and v
    uint samples[4];  // of its quarters: low, high along u, high along v, both
    uint splits;      // bit 0: it is to be split along u, bit 1: along v
    uint priority;    // which go first where there is no room for all
    uint unmet;       // bits as of splits: it would be split further, but an entry is the least there is
    uint changed;     // pixels whose visibility its tile changed
};

const uint ROUNDS = 20u;

struct TreeState {
    uint counts[ROUNDS];   // regions in the list of a round
    uint refused[ROUNDS];  // regions of that list that were to be split and for which there was no room
};

const uint SPLIT_U = 1u;
const uint SPLIT_V = 2u;

// Lists of even and odd rounds take turns.
uint region_at(uint round, uint i) { return (round & 1u) * TREE_TILES + i; }

uint entry_at(uvec2 entry) { return entry.y << TREE_LEVELS | entry.x; }

// Words of the table from entries to tiles; 0 belongs to no round.
uint tile_word(uint round, uint tile) { return round + 1u << 16 | tile; }
