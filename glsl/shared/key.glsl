// Page keys: bits 28-31 hold ROOT_LEVEL + 1 - level (1 to 14, so coarse pages sort first and no key is 0),
// bits 0-27 the Morton code of the page's coordinates at its level, relative to the anchor.

uint spread(uint x) {
    x &= 0x3fffu;
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
    return (x | (x >> 8)) & 0x3fffu;
}

const uint NONE = 0xffffffffu;

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

uint key_of(int level, uvec2 page) { return uint(ROOT_LEVEL + 1 - level) << 28 | spread(page.x) | spread(page.y) << 1; }
int key_level(uint key) { return ROOT_LEVEL + 1 - int(key >> 28); }
uvec2 key_page(uint key) { return uvec2(unspread(key), unspread(key >> 1)); }

// The page `steps` levels coarser that contains the page of `key`; stops at the root level.
uint key_ancestor(uint key, int steps) {
    steps = min(steps, ROOT_LEVEL - key_level(key));
    uint morton = (key & 0x0fffffffu) >> (2 * steps);
    return ((key >> 28) - uint(steps)) << 28 | morton;
}

// Level-0 page (relative to the anchor) and the position inside it, in page units, of an eye-relative point.
void light_page(Frame frame, vec3 from_eye, out ivec2 page, out vec2 inside) {
    vec2 ls = vec2(dot(frame.light_x.xyz, from_eye), dot(frame.light_y.xyz, from_eye));
    vec2 units = vec2(frame.light_x.w, frame.light_y.w) + ls * frame.page.y;
    vec2 whole = floor(units);
    page = frame.eye_page.xy + ivec2(whole);
    inside = units - whole;
}

bool on_grid(ivec2 page) { return all(greaterThanEqual(page, ivec2(0))) && all(lessThan(page, ivec2(2 << ROOT_LEVEL))); }
