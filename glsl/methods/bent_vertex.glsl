// A box around what a triangle covers in a map that bends its edges: six vertices a triangle, fetched by hand. Boxes that hold no
// texel's centre are empty (Lloyd et al. 2008; book, 4.2.4). Needs map_place.glsl. The includer defines FETCH_BINDING, the first of three, and
//   void cover(vec3 a, vec3 b, vec3 c, out vec2 low, out vec2 high, out float nearest)
// that finds what corners (the first two of map_place() and its last) cover in the map, low above high where that is nothing, and the greatest
// depth that is stored there.
layout(constant_id = 5) const uint SIDE = 2048u;
layout(constant_id = 6) const uint POSITION_STRIDE = 3u;
layout(constant_id = 7) const uint POSITION_OFFSET = 0u;
layout(constant_id = 8) const uint POSITION_FORMAT = 0u;
layout(std430, binding = FETCH_BINDING) readonly buffer Positions { uint positions[]; };
layout(std430, binding = FETCH_BINDING + 1) readonly buffer Indices { uint indices[]; };
#include "shared/position.glsl"

layout(location = 0) flat out vec3 corner_a;
layout(location = 1) flat out vec3 corner_b;
layout(location = 2) flat out vec3 corner_c;
layout(location = 3) flat out uint instance_index;
layout(location = 4) flat out uint triangle;

void cover(vec3 a, vec3 b, vec3 c, out vec2 low, out vec2 high, out float nearest);

// Texels by which coordinates in the map may be rounded; the rasteriser snaps to 1/256.
const float ROUNDING = 1.0 / 32.0;

void main() {
    instance_index = gl_InstanceIndex;
    triangle = gl_VertexIndex / 6;
    Instance instance = instances[gl_InstanceIndex];
    uint first = 3u * triangle;
    corner_a = map_place(instance, position(indices[first]), 0u).xyw;
    corner_b = map_place(instance, position(indices[first + 1u]), 0u).xyw;
    corner_c = map_place(instance, position(indices[first + 2u]), 0u).xyw;
    vec2 low, high;
    float nearest;
    cover(corner_a, corner_b, corner_c, low, high, nearest);
    // from the first texel whose centre may be covered to the end of the last
    vec2 from = clamp(ceil(low * float(SIDE) - 0.5 - ROUNDING), vec2(0.0), vec2(float(SIDE)));
    vec2 to = clamp(floor(high * float(SIDE) - 0.5 + ROUNDING) + 1.0, from, vec2(float(SIDE)));
    uint i = gl_VertexIndex % 6;
    bvec2 far = bvec2(i == 1u || i == 2u || i == 4u, i == 2u || i == 4u || i == 5u);
    // the greatest depth there is, and a little more for rounding: what is hidden needs no fragment
    gl_Position = vec4(mix(from, to, far) * (2.0 / float(SIDE)) - 1.0, min(nearest * 1.00001, 1.0), 1.0);
}
