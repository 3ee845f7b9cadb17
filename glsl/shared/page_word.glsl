// What a debug view knows of the page that serves a pixel, in a word: bits 0-11 layer, 12-16 level, 17 coarser than asked
// for, 18-19 LAYER_*, 31 valid.

// What a layer of the atlas is to the last frame.
const uint LAYER_EMPTY = 0u;
const uint LAYER_KEPT = 1u;    // of an earlier frame, not used in this one
const uint LAYER_CACHED = 2u;  // used, drawn in an earlier frame
const uint LAYER_DRAWN = 3u;   // drawn in this frame

uint make_page_word(uint slot, int level, bool coarser, uint state) {
    return 0x80000000u | state << 18 | (coarser ? 1u << 17 : 0u) | uint(level) << 12 | slot;
}
uint word_slot(uint word) { return word & 0xfffu; }
uint word_level(uint word) { return word >> 12 & 31u; }
bool word_coarser(uint word) { return (word >> 17 & 1u) != 0u; }
uint word_state(uint word) { return word >> 18 & 3u; }
