// What the passes of forward shadow mapping share. Places in a map are whole numbers of 1/256 texel, and so are weights: sums do
// not depend on the order of splats.
layout(constant_id = 2) const uint REACH = 384u;  // radius of the kernel

// The surface under a pixel as a layer of the map would hold it. As `ForwardSample`.
struct ForwardSample {
    int at_x;       // from the layer's corner
    int at_y;
    float nearest;  // greatest stored depth there that matches
    float farthest; // least
    float slope_x;  // change of both to the next texel on the receiver's plane
    float slope_y;
    uint layer;     // or NO_SURFACE, UNLIT, OUTSIDE
    uint pad;
};

const uint NO_SURFACE = 0xffffffffu;
const uint UNLIT = 0xfffffffeu;    // turned away from the light, or beyond its reach
const uint OUTSIDE = 0xfffffffdu;  // no layer holds it

// Of a frame of one light. As `ForwardCounts`: it begins with an indirect draw.
struct ForwardCounts {
    uint vertices;  // VERTICES for each block of texels that is splatted
    uint instances;
    uint first_vertex;
    uint first_instance;
    uint holes;     // pixels that no splat reaches and that the map does not shadow
};

// In place of a pixel's sum.
const uint HOLE = 0xffffffffu;

const uint BLOCK = 8u;  // texels along a side of a block
const uint VERTICES = 6u * BLOCK * BLOCK;

// A block's number: 11 bits each for column and row, then the layer.
uint block_word(uvec3 block) { return block.x | block.y << 11 | block.z << 22; }
uvec3 block_of(uint word) { return uvec3(word & 0x7ffu, word >> 11 & 0x7ffu, word >> 22); }

ivec2 place(ForwardSample s) { return ivec2(s.at_x, s.at_y); }
ivec2 centre(ivec2 texel) { return 256 * texel + 128; }

// What must be added to the depths of a sample to have them on its plane at the middle of a texel.
float depth_change(ForwardSample s, ivec2 texel) {
    vec2 away = vec2(centre(texel) - place(s)) / 256.0;
    return s.slope_x * away.x + s.slope_y * away.y;
}

// The kernel along one axis, 0 to 255: (1 - (d / radius)^2)^2. It is 0 from 0.968 radii on.
uint weight(int away) {
    uint d = uint(abs(away));
    if (d >= REACH) {
        return 0u;
    }
    uint a = (REACH * REACH - d * d) * 255u / (REACH * REACH);
    return a * a / 255u;
}
