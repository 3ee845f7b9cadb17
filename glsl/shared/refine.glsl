// Order of service: refine the nodes with the most pixels gained per page (Fernando 2002, sec. 2.4: benefit per cost).
// Roots come before all that: a light has coarse shadows before another has finer ones.

const uint RANKS = 2048u;        // of nodes that are refined
const uint ALL_RANKS = 4096u;    // from RANKS on: of roots that get their page

uint child_count(Node node) {
    uint count = 0u;
    for (uint q = 0u; q < 4u; q++) {
        count += node.child[q] != 0u ? 1u : 0u;
    }
    return count;
}

// Layers of the atlas that a page needs.
int page_layers(uint marks) { return (marks & MARK_DYNAMIC) != 0u ? 2 : 1; }

// Layers that must be drawn when a page is chosen.
int page_draws(uint slot, uint marks) { return (slot == 0u || (slot & STALE) != 0u ? 1 : 0) + page_layers(marks) - 1; }

// Parts of Node.cost.
uint cost_of(uint rank, int draws, int layers) { return rank | uint(draws + 16) << 16 | uint(layers + 16) << 24; }
uint cost_rank(uint cost) { return cost & 0xffffu; }
int cost_draws(uint cost) { return int((cost >> 16) & 0xffu) - 16; }
int cost_layers(uint cost) { return int(cost >> 24) - 16; }

// Order of the nodes of one rank, coarse levels first, so that those before any place are connected with their ancestors.
const uint ORDERS = 8192u;
uint draw_order(uvec2 key) { return (uint(ROOT_LEVEL - key_level(key)) * ORDERS + key_hash(key) % ORDERS) / uint(LEVELS); }

// Whether a node is replaced by its children as far as the layers of the atlas go.
bool fits(Node node, uint threshold) { return child_count(node) > 0u && (node.ranks & 0xffffu) >= threshold; }

// 64 buckets an octave of the ratio weighted pixels / pages, in exact integer arithmetic; 0 means "never refined".
uint refine_rank(uint benefit, int cost) {
    if (cost <= 0) {
        return RANKS - 1u;
    }
    uint ratio = benefit < (1u << 27) ? (benefit << 4) / uint(cost) : min(benefit / uint(cost), 0x0fffffffu) << 4;
    ratio = max(ratio, 1u);
    uint high = uint(findMSB(ratio));
    uint fraction = ((ratio << (31u - high)) >> 25) & 63u;
    return clamp(high * 64u + fraction, 1u, RANKS - 2u);
}

// Rank of a root: those of directional lights first, then those of most pixels, with ties told apart.
uint root_rank(uvec2 key, Node node, bool directional) {
    uint rank = RANKS - 1u;
    if (!directional) {
        rank = min(refine_rank(min(node.own, 0x3fffffffu) + min(node.below, 0x3fffffffu), page_layers(node.marks)), RANKS - 33u);
    }
    return RANKS + ((rank & ~31u) | (key_hash(key) & 31u));
}
