// Where the fit without a warp has the texels of the warped map. The includer defines CENTRES_BINDING and a constant SIDE.
layout(std430, binding = CENTRES_BINDING) readonly buffer Centres { vec2 centres[]; };  // centre and width, [0, 1]; SIDE along u, then along v

float texel_centre(uint axis, uint texel) { return centres[axis * SIDE + texel].x; }
