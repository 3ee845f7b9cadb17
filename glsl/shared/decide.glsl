// What the shadow map can decide about a receiver and what only the casters can. Needs umbrage_lookup.glsl.

const int MAP_LIT = 1;
const int MAP_SHADOWED = 0;
const int MAP_UNDECIDED = -1;

// Share of the depth bias by which a surface that shadows nothing may rise above the receiver's plane.
const float SELF = 0.25;

// Decided where all texels around the receiver agree and leave no doubt: casters above the plane by more than the bias, or
// none above it by more than a share of that.
int map_decides(PageSample s) {
    bool lit = true;
    bool shadowed = true;
    for (int y = -1; y <= 1; y += 2) {
        for (int x = -1; x <= 1; x += 2) {
            // the four texels around a corner of the receiver's texel
            vec2 corner = clamp(floor(s.texel) + 0.5 + 0.5 * vec2(x, y), vec2(1.0), vec2(textureSize(atlas, 0).xy) - 1.0);
            vec2 first = corner - 0.5 - s.texel;
            float depth = s.depth + dot(s.slope, first);
            vec4 plane = vec4(depth, depth + s.slope.x, depth + s.slope.y, depth + s.slope.x + s.slope.y);
            vec4 casters = umbrage_casters(s.entry, corner);
            lit = lit && all(lessThanEqual(casters, plane + SELF * s.bias));
            shadowed = shadowed && all(greaterThan(casters, plane + s.bias));
        }
    }
    return lit ? MAP_LIT : shadowed ? MAP_SHADOWED : MAP_UNDECIDED;
}
