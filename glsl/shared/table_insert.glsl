// Insertion into the page table; include after table.glsl with a writable `table_keys`.

// The slot of the key, or NONE when the table is as good as full. `fresh` tells whether this call put it there.
uint table_insert(uint key, out bool fresh) {
    uint slot = table_slot(key);
    fresh = false;
    for (uint i = 0u; i < MAX_PROBES; i++) {
        uint stored = table_keys[slot];
        if (stored == 0u) {
            stored = atomicCompSwap(table_keys[slot], 0u, key);
            fresh = stored == 0u;
        }
        if (stored == 0u || stored == key) {
            return slot;
        }
        slot = (slot + 1u) & (TABLE_SIZE - 1u);
    }
    return NONE;
}
