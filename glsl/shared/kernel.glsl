// Percentage-closer filtering (Reeves et al. 1987; book, 5.1.4): the share of a kernel's texels at which the receiver's plane
// is not behind the casters. Needs receiver.glsl, the constants FILTER and TAPS, and the depths of casters, the greatest of a
// few layers:
//   uint layer_count(uvec2 layers), uint layer_of(uvec2 layers, uint i)
//   vec4 layer_quad(uint layer, vec2 low): at the texels low, low + (1, 0), low + (0, 1) and low + (1, 1)
//   float layer_depth(uint layer, vec2 texel)
// Kernels read texels up to TAPS / 2, rounded up, beyond that of the receiver; those farther out have weight 0.

const uint FILTER_HARD = 0u;
const uint FILTER_PCF = 1u;       // the TAPS x TAPS texels nearest to the receiver
const uint FILTER_POISSON = 2u;   // texels at points of a disc TAPS texels across
const uint FILTER_BILINEAR = 3u;  // a box of TAPS x TAPS bilinear lookups, a texel apart

// Points of a unit disc, each as far as can be from those before it, so that the first few of them fill it too.
const vec2 DISC[32] = vec2[32](
    vec2(-0.9650, -0.0821), vec2(0.3185, 0.0683), vec2(-0.2706, -0.5490), vec2(-0.3661, 0.5108),
    vec2(0.3921, -0.5964), vec2(0.2326, 0.7000), vec2(-0.3971, -0.0253), vec2(0.7745, -0.2206),
    vec2(0.7015, 0.4063), vec2(-0.7726, 0.3298), vec2(-0.7171, -0.4503), vec2(0.0747, -0.2970),
    vec2(0.0616, -0.8615), vec2(-0.0309, 0.2789), vec2(-0.1765, 0.8622), vec2(0.9112, 0.1134),
    vec2(0.7257, -0.5681), vec2(0.4405, -0.2431), vec2(-0.5482, -0.7367), vec2(0.5645, 0.7397),
    vec2(0.3714, 0.3949), vec2(-0.6553, 0.6438), vec2(-0.2441, -0.8623), vec2(-0.0716, -0.0220),
    vec2(-0.0602, 0.5832), vec2(0.6200, 0.0579), vec2(-0.6762, -0.1386), vec2(-0.2355, -0.2623),
    vec2(0.3524, -0.8920), vec2(0.1002, -0.5766), vec2(-0.4658, 0.8417), vec2(-0.3022, 0.2316));
const uint DISC_SAMPLES = TAPS <= 4u ? 16u : TAPS == 5u ? 25u : 32u;

// Weights of columns (or rows) i and i + 1; `f`: share of the first that lies outside the kernel.
vec2 box_weights(uint i, float f) {
    return vec2(i == 0u ? 1.0 - f : i < TAPS ? 1.0 : f, i + 1u < TAPS ? 1.0 : i + 1u == TAPS ? f : 0.0);
}

float box_visibility(Plane plane, uvec2 layers) {
    const bool bilinear = FILTER == FILTER_BILINEAR;
    vec2 start = plane.texel - 0.5 * float(bilinear ? TAPS : TAPS - 1u);
    vec2 low = floor(start);
    vec2 f = bilinear ? start - low : vec2(0.0);
    float first = plane.depth + dot(plane.slope, low + 0.5 - plane.texel);
    vec4 quad = first + vec4(0.0, plane.slope.x, plane.slope.y, plane.slope.x + plane.slope.y);
    const uint side = bilinear ? TAPS + 1u : TAPS;
    uint count = layer_count(layers);
    float sum = 0.0;
    for (uint y = 0u; y < side; y += 2u) {
        vec2 rows = box_weights(y, f.y);
        vec2 along = vec2(0.0);
        // a row at a time: few loops over layers, and few registers
        vec4 casters[5] = vec4[5](vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
        for (uint i = 0u; i < count; i++) {
            for (uint x = 0u; x < side; x += 2u) {
                casters[x / 2u] = max(casters[x / 2u], layer_quad(layer_of(layers, i), low + vec2(x, y)));
            }
        }
        for (uint x = 0u; x < side; x += 2u) {
            vec4 depths = quad + (float(x) * plane.slope.x + float(y) * plane.slope.y);
            vec4 lit = vec4(greaterThanEqual(depths, casters[x / 2u]));
            vec2 columns = box_weights(x, f.x);
            along += lit.xz * columns.x + lit.yw * columns.y;
        }
        sum += dot(rows, along);
    }
    // rounding leaves what is wholly lit a little short of 1
    return min(sum * (1.000001 / float(TAPS * TAPS)), 1.0);
}

// `turn`: cosine and sine of the disc's rotation.
float disc_visibility(Plane plane, uvec2 layers, vec2 turn) {
    vec2 axis = 0.5 * float(TAPS) * turn;
    uint lit = 0u;
    for (uint i = 0u; i < DISC_SAMPLES; i++) {
        vec2 texel = floor(plane.texel + vec2(dot(DISC[i], vec2(axis.x, -axis.y)), dot(DISC[i], axis.yx)));
        float depth = plane.depth + dot(plane.slope, texel + 0.5 - plane.texel);
        float caster = layer_depth(layer_of(layers, 0u), texel);
        if (layer_count(layers) > 1u) {
            caster = max(caster, layer_depth(layer_of(layers, 1u), texel));
        }
        lit += depth >= caster ? 1u : 0u;
    }
    return float(lit) / float(DISC_SAMPLES);
}

// A rotation that differs from pixel to pixel. Needs key.glsl.
vec2 pixel_turn(uvec2 pixel) {
    float angle = float(hash(pixel.x ^ hash(pixel.y)) >> 8) * (6.28318530718 / 16777216.0);
    return vec2(cos(angle), sin(angle));
}

// 0 in shadow to 1 lit. `pixel`: for the rotation of the disc.
float kernel_visibility(Plane plane, uvec2 layers, uvec2 pixel) {
    return FILTER == FILTER_POISSON ? disc_visibility(plane, layers, pixel_turn(pixel)) : box_visibility(plane, layers);
}

// How much the plane's depth may differ within the kernel from that at the receiver.
float kernel_reach(Plane plane) { return (0.5 * float(TAPS) + 0.5) * (abs(plane.slope.x) + abs(plane.slope.y)); }
