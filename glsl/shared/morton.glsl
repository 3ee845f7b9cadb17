// Keys in the form in which they are sorted: level and face as in key.glsl, then the Morton code of the page, 14 and 32
// bits, so that pages with a common ancestor lie side by side. Needs key.glsl.

uint spread(uint x) {
    x &= 0xffffu;
    x = (x | (x << 8)) & 0x00ff00ffu;
    x = (x | (x << 4)) & 0x0f0f0f0fu;
    x = (x | (x << 2)) & 0x33333333u;
    return (x | (x << 1)) & 0x55555555u;
}

uint unspread(uint x) {
    x &= 0x55555555u;
    x = (x | (x >> 1)) & 0x33333333u;
    x = (x | (x >> 2)) & 0x0f0f0f0fu;
    x = (x | (x >> 4)) & 0x00ff00ffu;
    return (x | (x >> 8)) & 0xffffu;
}

uvec2 key_to_morton(uvec2 key) {
    uvec2 page = key_page(key);
    uint high = spread(page.x >> 16) | spread(page.y >> 16) << 1;
    return uvec2((key.x & 0xffffc000u) | high, spread(page.x) | spread(page.y) << 1);
}

uvec2 key_from_morton(uvec2 morton) {
    uint high = morton.x & 0x3fffu;
    uvec2 page = uvec2(unspread(high) << 16 | unspread(morton.y), unspread(high >> 1) << 16 | unspread(morton.y >> 1));
    return key_of(key_level(morton), key_face(morton), page);
}

// As key_ancestor.
uvec2 morton_ancestor(uvec2 morton, int steps) {
    steps = min(steps, ROOT_LEVEL - key_level(morton));
    uint bits = 2u * uint(steps);
    uint high = morton.x & 0x3fffu;
    uint low = bits == 0u ? morton.y : bits < 32u ? morton.y >> bits | high << (32u - bits) : high >> (bits - 32u);
    return uvec2(((morton.x >> 27) - uint(steps)) << 27 | (morton.x & 0x07ffc000u) | (bits < 32u ? high >> bits : 0u), low);
}
