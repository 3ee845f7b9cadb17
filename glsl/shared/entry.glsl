// Entries of the page table: bit 31 valid, bits 26-30 level of the serving page, bit 25 drawn for a light that has turned
// since, bits 12-23 layer of its moving casters + 1 (0: none), bits 0-11 layer of the others.

uint make_entry(int level, uint turned, uint slot, uint dynamic_slot) {
    return 0x80000000u | uint(level) << 26 | turned << 25 | (dynamic_slot == NONE ? 0u : dynamic_slot + 1u) << 12 | slot;
}
int entry_level(uint entry) { return int(entry >> 26) & 31; }
uint entry_slot(uint entry) { return entry & 0xfffu; }
uint entry_dynamic(uint entry) { return (entry >> 12) & 0xfffu; }  // + 1
bool entry_turned(uint entry) { return (entry >> 25 & 1u) != 0u; }
