// The page table: an open-addressing hash table of page keys. Needs `table_keys` (uint array, 0 = empty) and TABLE_SIZE.

// A probe longer than this means that the table is as good as full: at half load such runs do not occur.
const uint MAX_PROBES = 256u;

uint table_slot(uint key) { return hash(key) & (TABLE_SIZE - 1u); }

uint table_find(uint key) {
    uint slot = table_slot(key);
    for (uint i = 0u; i < MAX_PROBES; i++) {
        uint stored = table_keys[slot];
        if (stored == key) {
            return slot;
        }
        if (stored == 0u) {
            return NONE;
        }
        slot = (slot + 1u) & (TABLE_SIZE - 1u);
    }
    return NONE;
}
