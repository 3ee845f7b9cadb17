// What the shadow map can decide about a receiver and what only the casters can. Needs umbrage_lookup.glsl.

const int MAP_LIT = 1;
const int MAP_SHADOWED = 0;
const int MAP_UNDECIDED = -1;
const int MAP_LOOK = 2;  // its texels decide

// Share of the depth bias by which a surface that shadows nothing may rise above the receiver's plane.
const float SELF = 0.25;

// Most pixels across a texel: what a coarser one holds says too little about a pixel.
const float MOST_PIXELS = 8.0;

// What four texels leave possible: no caster above the plane by more than a share of the bias, or all by more than the bias and
// `lift`. Returns how many of them are lit.
float quad_decides(Plane plane, uvec2 layers, vec2 low, float lift, inout bool lit, inout bool shadowed) {
    float first = plane.depth + dot(plane.slope, low + 0.5 - plane.texel);
    vec4 depths = vec4(first, first + plane.slope.x, first + plane.slope.y, first + plane.slope.x + plane.slope.y);
    vec4 casters = caster_quad(layers, low);
    lit = lit && all(lessThanEqual(casters, depths - (1.0 - SELF) * plane.bias));
    shadowed = shadowed && all(greaterThan(casters, depths + lift));
    return dot(vec4(greaterThanEqual(depths, casters)), vec4(1.0));
}

// Decided where seven of the nine texels around the receiver agree and leave no doubt. `fine`: whether the rounding of depths is
// less than the pixel, so that what is too low to be told from the plane does not matter. `leans`: whether half of them are lit,
// the receiver's own twice.
int map_decides(Plane plane, uvec2 layers, bool fine, out bool leans) {
    bool lit = fine;
    bool shadowed = true;
    float tests = 0.0;
    // two opposite corners of the receiver's texel, four texels around each
    for (int side = -1; side <= 1; side += 2) {
        vec2 low = floor(plane.texel) - 0.5 + 0.5 * float(side);
        low = clamp(low, vec2(0.0), vec2(textureSize(atlas, 0).xy) - 2.0);
        tests += quad_decides(plane, layers, low, 0.0, lit, shadowed);
    }
    leans = tests >= 4.0;
    return lit ? MAP_LIT : shadowed ? MAP_SHADOWED : MAP_UNDECIDED;
}

// The same for all points of the plane within `extent` texels along both axes, which lie in one layer, and those as far as `lift`
// above them: decided where all texels under them and one more around agree, if these are no more than `most` quads.
int map_decides_all(Plane plane, uvec2 layers, bool fine, vec2 extent, float lift, float most) {
    vec2 low = floor(plane.texel - extent) - 1.0;
    vec2 high = floor(plane.texel + extent) + 1.0;
    vec2 quads = floor((high - low) * 0.5) + 1.0;
    bool shadowed = quads.x * quads.y <= most;
    bool lit = shadowed && fine;
    vec2 last = vec2(textureSize(atlas, 0).xy) - 2.0;
    for (float y = low.y; y <= high.y && (lit || shadowed); y += 2.0) {
        for (float x = low.x; x <= high.x && (lit || shadowed); x += 2.0) {
            quad_decides(plane, layers, min(vec2(x, y), last), lift, lit, shadowed);
        }
    }
    return lit ? MAP_LIT : shadowed ? MAP_SHADOWED : MAP_UNDECIDED;
}
