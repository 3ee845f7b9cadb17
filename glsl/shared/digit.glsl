// The 4 bits of a key that a pass of the sort looks at. Needs `digit`, the first of them.
uint digit_of(uvec2 key) { return ((digit < 32u ? key.y >> digit : key.x >> (digit - 32u))) & 15u; }
