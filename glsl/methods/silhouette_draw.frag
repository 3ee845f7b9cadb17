#version 460

// The point of a silhouette edge that a texel holds (source, 3.1): an end of the edge, or the middle of where it meets the
// diagonals. Where several edges pass a texel the nearest to the light wins, then the one of the greatest number, whatever order
// they are drawn in.
layout(constant_id = 0) const uint LAYER = 0u;
layout(constant_id = 2) const uint NUMBER_BITS = 16u;
layout(binding = 2) uniform sampler2DArray map;
layout(location = 0) flat in vec3 from;
layout(location = 1) flat in vec3 to;
layout(location = 2) flat in uint number;
layout(location = 0) out vec2 point;

// Texels by which a texel is enlarged, so that edges through a corner reach all four texels there; more than rounding at the
// far end of the largest map.
const float MARGIN = 1.0 / 256.0;
// Texels between a point and the border of its texel, so that no sector of the lookup is half a turn; as float16 holds them.
const float INSET = 1.0 / 1024.0;
// Bits of the winning depth: below 1.0 when read as a float, and no denormal.
const uint KEY_BITS = 29u;
const uint LEAST_FLOAT = 0x00800000u;

bool inside(vec2 p) { return all(greaterThanEqual(p, vec2(-MARGIN))) && all(lessThanEqual(p, vec2(1.0 + MARGIN))); }

// Where the edge meets a diagonal; false where it does not within the texel.
bool meets(float before, float change, vec2 a, vec2 along, out float t) {
    t = before / change;
    return change != 0.0 && t >= 0.0 && t <= 1.0 && inside(a + t * along);
}

void main() {
    ivec2 texel = ivec2(gl_FragCoord.xy);
    vec2 a = from.xy - vec2(texel), along = to.xy - from.xy;
    float t = 0.0;
    if (!inside(a)) {
        float rising, falling;
        bool first = meets(a.y - a.x, along.x - along.y, a, along, rising);
        bool second = meets(1.0 - a.x - a.y, along.x + along.y, a, along, falling);
        if (inside(to.xy - vec2(texel))) {
            t = 1.0;
        } else if (first && second) {
            t = 0.5 * (rising + falling);
        } else if (first || second) {
            t = first ? rising : falling;
        } else {
            discard;
        }
    }
    float depth = mix(from.z, to.z, t);
    ivec2 last = textureSize(map, 0).xy - 1;
    float farthest = 1.0;
    for (int i = 0; i < 4; i++) {
        farthest = min(farthest, texelFetch(map, ivec3(min(texel + ivec2(i & 1, i >> 1), last), LAYER), 0).r);
    }
    // hidden from the light: behind what all four corners see; with room for rounding
    if (depth < farthest * (1.0 - 1e-6)) {
        discard;
    }
    point = clamp(a + t * along, INSET, 1.0 - INSET);
    uint steps = uint(clamp(depth, 0.0, 1.0) * float((1u << (KEY_BITS - NUMBER_BITS)) - 1u));
    gl_FragDepth = uintBitsToFloat(LEAST_FLOAT + (steps << NUMBER_BITS) + number);
}
