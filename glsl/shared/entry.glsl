// Entries of the page table: bit 31 valid, bits 27-30 level of the serving page, bit 26 drawn for a light that has turned
// since, bits 13-25 layer of its moving casters + 1 (0: none), bits 0-12 layer of the others.

uint make_entry(int level, uint turned, uint slot, uint dynamic_slot) {
    return 0x80000000u | uint(level) << 27 | turned << 26 | (dynamic_slot == NONE ? 0u : dynamic_slot + 1u) << 13 | slot;
}
int entry_level(uint entry) { return int(entry >> 27) & 15; }
uint entry_slot(uint entry) { return entry & 0x1fffu; }
uint entry_dynamic(uint entry) { return (entry >> 13) & 0x1fffu; }  // + 1
bool entry_turned(uint entry) { return (entry >> 26 & 1u) != 0u; }
