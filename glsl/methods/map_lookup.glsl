#include "shared/frame.glsl"
#include "shared/key.glsl"
#include "shared/receiver.glsl"
#include "methods/fit.glsl"
#include "methods/sample.glsl"
#include "methods/bias.glsl"
#include "methods/confidence.glsl"
#include "methods/tile.glsl"

// A lookup with receiver-plane bias: the nearest texel, or a kernel around it; 1 where there is no surface or no layer holds the sample.
layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 2) const uint FILTER = 0u;
layout(constant_id = 3) const uint TAPS = 4u;
layout(constant_id = 4) const uint BIAS = 0u;  // BIAS_*
layout(constant_id = 6) const uint TILES = 0u;  // 1: each sample's layer was picked
layout(constant_id = 8) const uint CENTRED = 0u;  // 1: the bias shrinks to nothing towards the texel's centre
layout(std430, binding = 5) readonly buffer Fits { Fit fits[]; };
layout(binding = 6) uniform sampler2DArray map;
layout(binding = 7, r32f) writeonly uniform image2D visibility_image;
layout(binding = 8) uniform sampler2DArray second_map;  // with BIAS_MIDPOINT and BIAS_DUAL; otherwise what ids.frag wrote
layout(std430, binding = 9) readonly buffer Picked { uint picked[]; };  // with TILES
layout(binding = 10) uniform usampler2D owners;  // see izb_owner.glsl; with BIAS_IDS
layout(constant_id = 7) const uint SILHOUETTES = 0u;
layout(binding = 11) uniform sampler2DArray silhouette_map;  // with SILHOUETTES

#include "methods/silhouette_lookup.glsl"

uint layer_count(uvec2 layers) { return 1u; }
uint layer_of(uvec2 layers, uint i) { return layers.x; }
vec4 layer_quad(uint layer, vec2 low) {
    // the gather of a nearest sampler: its four texels meet at the coordinate given
    return textureGather(map, vec3((low + 1.0) / vec2(textureSize(map, 0).xy), float(layer)), 0).wzxy;
}
float layer_depth(uint layer, vec2 texel) { return texelFetch(map, ivec3(texel, layer), 0).r; }

#include "shared/kernel.glsl"
#include "methods/place.glsl"
#include "methods/stored_z.glsl"

// A sample as a layer holds it.
struct Held {
    float z;      // in light space, world units
    float q;      // what divides stored depths
    vec2 growth;  // share by which 1 / q falls to the next texel: a texel's middle is divided by its own
    float size;   // of a texel, world units
    vec2 slope;   // change of z to the next texel, in the receiver's plane
    vec2 triangle;  // that is seen, as ids.frag has it; with BIAS_IDS
    Plane plane;  // stored depth over the texels, nearer to the light by the bias; with BIAS_PLANE
};

// Whether a texel lets light pass to a sample.
bool lit_by(uint layer, Held held, ivec2 texel) {
    float caster = texelFetch(map, ivec3(texel, layer), 0).r;
    if (BIAS == BIAS_PLANE) {
        return depth_at(held.plane, vec2(texel)) >= caster;
    }
    if (BIAS == BIAS_IDS && texelFetch(second_map, ivec3(texel, layer), 0).rg == held.triangle) {
        return true;
    }
    float q = held.q / (1.0 - dot(held.growth, vec2(texel) + 0.5 - held.plane.texel));
    float nearest = z_of(caster * q);
    // rounding
    float stored = nearest + light.rule.y;
    if (BIAS == BIAS_CONSTANT || BIAS == BIAS_IDS) {
        stored += light.rule.x * held.size;
    } else if (BIAS == BIAS_SLOPE) {
        stored += light.rule.x * (0.25 * held.size + 0.5 * (abs(held.slope.x) + abs(held.slope.y)));
    } else if (BIAS == BIAS_MIDPOINT || BIAS == BIAS_DUAL) {
        float behind = 0.5 * (z_of(texelFetch(second_map, ivec3(texel, layer), 0).r * q) - nearest);
        stored += BIAS == BIAS_DUAL ? min(behind, light.rule.x * held.size) : behind;
    }
    return held.z <= stored;
}

// By the four texels around a sample, or, where they differ, by the one that the silhouettes between them leave to it.
bool lit_by_corners(uint layer, Held held, vec2 at) {
    vec2 p = at - 0.5;
    ivec2 low = ivec2(floor(p));
    ivec2 last = textureSize(map, 0).xy - 1;
    bool lit[4];
    for (int i = 0; i < 4; i++) {
        lit[i] = lit_by(layer, held, clamp(low + ivec2(i & 1, i >> 1), ivec2(0), last));
    }
    if (lit[0] == lit[1] && lit[1] == lit[2] && lit[2] == lit[3]) {
        return lit[0];
    }
    ivec2 corner = corner_of(layer, low, p - vec2(low));
    return lit[corner.x + 2 * corner.y];
}

#ifdef STORED
// Whether a layer lets light pass to a sample, by what the includer has it hold.
bool lit_by_stored(uint layer, uvec2 pixel, Sample s, Place p, Held held);
#endif

// False where the layer does not hold the sample.
bool look_up(uint layer, uvec2 pixel, Sample s, out float lit) {
    Place p;
    if (!place_of(layer, s, p)) {
        return false;
    }
    float share = CENTRED == 1u ? 1.0 - confidence(p.texel) : 1.0;
    Plane plane = plane_of(p, fits[layer], share * full_bias(p));
    vec2 triangle = BIAS == BIAS_IDS ? vec2(texelFetch(owners, ivec2(pixel), 0).xy) : vec2(0.0);
    vec2 growth = vec2(dot(fits[layer].row_w.xy, p.along[0]), dot(fits[layer].row_w.xy, p.along[1])) / p.q;
    Held held = Held(p.ls.z, p.q, growth, max(p.size.x, p.size.y), p.slope, triangle, plane);
#ifdef STORED
    lit = lit_by_stored(layer, pixel, s, p, held) ? 1.0 : 0.0;
    return true;
#endif
    if (FILTER != FILTER_HARD) {
        lit = kernel_visibility(plane, uvec2(layer, 0u), pixel);
    } else {
        lit = (SILHOUETTES == 1u ? lit_by_corners(layer, held, p.texel) : lit_by(layer, held, ivec2(p.texel))) ? 1.0 : 0.0;
    }
    return true;
}

float visibility(uvec2 pixel, float depth) {
    Sample s = sample_at(pixel, depth);
    if (!shone_on(pixel, s)) {
        return 0.0;
    }
    float lit;
    if (TILES == 1u) {
        s.layer = picked[pixel.y * frame.size.x + pixel.x];
        if (s.layer == KEPT_TILE) {
            return 1.0;
        }
        if (s.layer != NO_TILE && look_up(s.layer, pixel, s, lit)) {
            return lit;
        }
        atomicAdd(outside, 1u);
        return 1.0;
    }
    if (look_up(s.layer, pixel, s, lit)) {
        float next;
        return s.next > 0.0 && look_up(s.layer + 1u, pixel, s, next) ? mix(lit, next, s.next) : lit;
    }
    atomicAdd(outside, 1u);
    for (uint layer = 0u; layer < LAYERS; layer++) {
        if (look_up(layer, pixel, s, lit)) {
            return lit;
        }
    }
    return 1.0;
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, frame.size.xy))) {
        return;
    }
    float depth = texelFetch(depth_image, ivec2(pixel), 0).r;
    imageStore(visibility_image, ivec2(pixel), vec4(depth > 0.0 ? visibility(pixel, depth) : 1.0));
}
