// Unit vectors in 32 bits: octahedral, two 16-bit signed fractions. What `ReceiverImages::normal` holds.

uint umbrage_encode_normal(vec3 n) {
    vec2 p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    if (n.z < 0.0) {
        p = (1.0 - abs(p.yx)) * vec2(p.x >= 0.0 ? 1.0 : -1.0, p.y >= 0.0 ? 1.0 : -1.0);
    }
    return packSnorm2x16(p);
}
