// How far a lookup is from the texel's centre, where alone the map holds the scene (Scherzer et al. 2007; book, 4.7): 1 at the
// centre, 0 at the texel's border. `texel`: place in the map in texels.
float confidence(vec2 texel) {
    vec2 off = abs(fract(texel) - 0.5);
    return 1.0 - 2.0 * max(off.x, off.y);
}
