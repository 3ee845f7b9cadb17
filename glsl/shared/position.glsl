// Positions of vertices. Needs `positions` (float array) and two constants, in words: POSITION_STRIDE from one vertex to the
// next and POSITION_OFFSET of the position in it.

vec3 position(uint vertex) {
    uint at = POSITION_STRIDE * vertex + POSITION_OFFSET;
    return vec3(positions[at], positions[at + 1u], positions[at + 2u]);
}
