// The page table: an open-addressing hash table of page keys. Needs key.glsl, `table_keys` (uint array, two words a slot:
// x of the key and the complement of y, so that an empty slot is all zeros) and TABLE_SIZE.

// A probe longer than this means that the table is as good as full: at half load such runs do not occur.
const uint MAX_PROBES = 256u;

uint table_slot(uvec2 key) { return key_hash(key) & (TABLE_SIZE - 1u); }
uvec2 table_key(uint slot) { return uvec2(table_keys[2u * slot], ~table_keys[2u * slot + 1u]); }

uint table_find(uvec2 key) {
    uint slot = table_slot(key);
    for (uint i = 0u; i < MAX_PROBES; i++) {
        uvec2 stored = table_key(slot);
        if (stored == key) {
            return slot;
        }
        if (stored.x == 0u) {
            return NONE;
        }
        slot = (slot + 1u) & (TABLE_SIZE - 1u);
    }
    return NONE;
}
