// Insertion into the page table; include after table.glsl with a writable `table_keys`.

// The slot of the key, or NONE when the table is as good as full. `fresh` tells whether this call put it there.
// Each word of a slot is claimed once. Threads with the same first word race for the second, and whoever loses goes on:
// every thread that skips a slot has seen that it holds another key for good, so no key has two slots.
uint table_insert(uvec2 key, out bool fresh) {
    uint slot = table_slot(key);
    uint word = ~key.y;
    fresh = false;
    for (uint i = 0u; i < MAX_PROBES; i++) {
        uint stored = table_keys[2u * slot];
        if (stored == 0u) {
            stored = atomicCompSwap(table_keys[2u * slot], 0u, key.x);
        }
        if (stored == 0u || stored == key.x) {
            stored = table_keys[2u * slot + 1u];
            if (stored == 0u) {
                stored = atomicCompSwap(table_keys[2u * slot + 1u], 0u, word);
                fresh = stored == 0u;
            }
            if (stored == 0u || stored == word) {
                return slot;
            }
        }
        slot = (slot + 1u) & (TABLE_SIZE - 1u);
    }
    return NONE;
}
