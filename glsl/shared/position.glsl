// Positions of vertices. Needs `positions` (uint array) and three constants: POSITION_STRIDE, words from one vertex to the next,
// POSITION_OFFSET, words before the position in it, and POSITION_FORMAT, as `PositionFormat`.

const uint POSITION_FLOAT_16 = 1u;
const uint POSITION_SNORM_16 = 2u;

vec3 position(uint vertex) {
    uint at = POSITION_STRIDE * vertex + POSITION_OFFSET;
    uint x = positions[at], y = positions[at + 1u];
    switch (POSITION_FORMAT) {
    case POSITION_FLOAT_16: return vec3(unpackHalf2x16(x), unpackHalf2x16(y).x);
    case POSITION_SNORM_16: return vec3(unpackSnorm2x16(x), unpackSnorm2x16(y).x);
    default: return vec3(uintBitsToFloat(x), uintBitsToFloat(y), uintBitsToFloat(positions[at + 2u]));
    }
}
