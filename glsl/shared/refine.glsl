// Order of service: refine the nodes with the most pixels gained per page (Fernando 2002, sec. 2.4: benefit per cost).

const uint RANKS = 2048u;

uint child_count(Node node) {
    uint count = 0u;
    for (uint q = 0u; q < 4u; q++) {
        count += node.child[q] != 0u ? 1u : 0u;
    }
    return count;
}

// Pages that refining adds: its children, less its own page when no pixel needs that any more. Roots always stay.
uint refine_cost(Node node, uint children) {
    return children - (node.own == 0u && key_level(node.key) < ROOT_LEVEL ? 1u : 0u);
}

// 64 buckets an octave of the ratio weighted pixels / pages, in exact integer arithmetic; 0 means "never refined".
uint refine_rank(uint benefit, uint cost) {
    if (cost == 0u) {
        return RANKS - 1u;
    }
    uint ratio = benefit < (1u << 27) ? (benefit << 4) / cost : min(benefit / cost, 0x0fffffffu) << 4;
    ratio = max(ratio, 1u);
    uint high = uint(findMSB(ratio));
    uint fraction = ((ratio << (31u - high)) >> 25) & 63u;
    return clamp(high * 64u + fraction, 1u, RANKS - 2u);
}
