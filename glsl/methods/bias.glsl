// What a receiver is compared with (book, 2.2.3, 2.2.4): where the stored surface lies, and how much nearer to the light it must
// be. As `BiasKind`.
const uint BIAS_PLANE = 0u;     // the receiver's plane at the texel's centre, and a bias of a texel and a part of its slope
const uint BIAS_CONSTANT = 1u;  // a constant, in texels
const uint BIAS_SLOPE = 2u;     // a quarter of that, and half the receiver's change of depth across a texel along both axes
const uint BIAS_SECOND = 3u;    // none; the map holds the sides that are turned away from the light
const uint BIAS_MIDPOINT = 4u;  // none; halfway between the first surface and the second
const uint BIAS_DUAL = 5u;      // the same, but no farther behind the first surface than a constant, in texels
const uint BIAS_IDS = 6u;       // a constant, in texels, unless the map holds the receiver's own triangle
