// A light's bits in a word of the mask. Needs MASK_BITS.
uint encode_visibility(float visibility) {
    return MASK_BITS == 32u ? floatBitsToUint(visibility) : uint(visibility * float((1u << MASK_BITS) - 1u) + 0.5);
}
