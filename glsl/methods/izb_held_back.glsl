// What translucent casters hold back of the light of each sample (book, 4.5.2: transmittance is the product of 1 - alpha), as the negated
// binary logarithm, in steps of 2^-16: sums of whole numbers do not depend on the order of casters. The includer defines HELD_BACK_BINDING.
layout(std430, binding = HELD_BACK_BINDING) buffer HeldBack { uint held_back[]; };  // by sample

const float STEPS = 65536.0;
const float DARK = 24.0;  // nothing is seen of 2^-24 of the light

// Whether a sample is shadowed by a point of this alpha alone.
bool hold_back(uint number, float alpha) {
    float halvings = -log2(max(1.0 - alpha, 0.0));
    if (halvings >= DARK) {
        return true;
    }
    // what is dark already needs no more, and never wraps around
    if (alpha > 0.0 && held_back[number] < uint(DARK * STEPS)) {
        atomicAdd(held_back[number], uint(halvings * STEPS + 0.5));
    }
    return false;
}

// Share of the light that comes to a sample.
float transmittance(uint number) {
    float halvings = float(held_back[number]) / STEPS;
    return halvings < DARK ? exp2(-halvings) : 0.0;
}
