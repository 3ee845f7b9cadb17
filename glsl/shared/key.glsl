// Page keys, two words: x holds ROOT_LEVEL + 1 - level in bits 27-31 (1 to 24, so coarse pages sort first and no key's
// x is 0), the face in bits 14-26 and the upper 14 bits of the page's column at its level in bits 0-13; y holds the lower
// 9 bits of the column above the 23 bits of the row. No page has a y of all ones.
// A face is a square seen from a light; page (0, 0) of the root level is all of it.

const int ROOT_LEVEL = 23;
const uint NONE = 0xffffffffu;
const uint FACES = 6u;  // of a light; directional and spot lights use the first

uvec2 key_of(int level, uint face, uvec2 page) {
    return uvec2(uint(ROOT_LEVEL + 1 - level) << 27 | face << 14 | page.x >> 9, (page.x & 0x1ffu) << 23 | page.y);
}
int key_level(uvec2 key) { return ROOT_LEVEL + 1 - int(key.x >> 27); }
uint key_face(uvec2 key) { return (key.x >> 14) & 0x1fffu; }
uvec2 key_page(uvec2 key) { return uvec2((key.x & 0x3fffu) << 9 | key.y >> 23, key.y & 0x7fffffu); }

// The page `steps` levels coarser that contains the page of `key`; stops at the root level.
uvec2 key_ancestor(uvec2 key, int steps) {
    int level = key_level(key);
    steps = min(steps, ROOT_LEVEL - level);
    return key_of(level + steps, key_face(key), key_page(key) >> steps);
}

// Which quarter of its parent a page is: bit 0 right, bit 1 lower.
uint key_quadrant(uvec2 key) { return (key.y >> 23 & 1u) | (key.y & 1u) << 1; }

// 2^n, exactly, for n from -126 to 127.
float power_of_two(int n) { return uintBitsToFloat(uint(n + 127) << 23); }

// A well-mixed word.
uint hash(uint word) {
    word ^= word >> 16;
    word *= 0x7feb352du;
    word ^= word >> 15;
    word *= 0x846ca68bu;
    return word ^ (word >> 16);
}
uint key_hash(uvec2 key) { return hash(key.x * 0x9e3779b1u ^ key.y); }
