// Samples and the pages of a quadtree that serve them. Takes bindings 0 to 6, needs frame.glsl, receiver.glsl and fit.glsl.
#include "methods/sample.glsl"
#include "methods/quadtree.glsl"
layout(std140, binding = 5) uniform VirtualBlock { VirtualMap virtual_map; };
layout(std430, binding = 6) readonly buffer Cells { Cell cells[]; };
#include "methods/quadtree_walk.glsl"

// A sample and what serves it.
struct Served {
    Sample at;
    uvec2 finest;  // page of FINEST that it lies in
    uint needed;   // depth that it asks for
    uint tile;
    uint cell;
    uint depth;    // of that
};

// False where there is no sample, where the light does not shine on it, and outside the virtual map.
bool served_sample(uvec2 pixel, out Served s) {
    if (any(greaterThanEqual(pixel, frame.size.xy))) {
        return false;
    }
    float depth = texelFetch(depth_image, ivec2(pixel), 0).r;
    s.at = sample_at(pixel, depth);
    if (depth <= 0.0 || !shone_on(pixel, s.at) || !finest_page(virtual_map, light_space(0u, s.at.from_eye).xy, s.finest)) {
        return false;
    }
    vec3 dx, dy;
    decode_derivatives(frame, texelFetch(receiver_image, ivec2(pixel), 0), depth, dx, dy);
    s.needed = needed_depth(virtual_map, turned(0u, dx).xy, turned(0u, dy).xy);
    s.tile = deepest_tile(s.finest, FINEST, s.cell, s.depth);
    return true;
}
