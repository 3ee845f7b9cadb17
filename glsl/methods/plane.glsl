// The plane that a warp is optimal for (Chong, Gortler 2004; book, 4.2.5), and the bins of normals and offsets by which it is found. The
// includer defines PLANE_BINDING, and BINS_BINDING where it needs bins.
struct DominantPlane {
    vec4 plane;    // a plane n . x = d relative to the eye: xyz: unit normal n, world space; w: d, world units
    vec4 forward;  // xyz: view direction, world space; w: length of the scene, which measures offsets
    uint sums[8];  // over the samples of the bin, as pairs of low and high words: three of normals + 1, one of offsets over that of the bin
    uint bin;      // the fullest
    uint count;    // samples in it
    uint pad[2];
};

layout(std430, binding = PLANE_BINDING) buffer PlaneBlock { DominantPlane dominant; };

// Normals are rounded to multiples of 1/4 along each axis, so that the axes themselves are in the middle of a bin.
const int NORMALS = 9;
// Offsets have eight bins an octave.
const uint OFFSETS = 128u;
const float PER_OCTAVE = 8.0, FIRST = -112.0;
const uint BINS = uint(NORMALS * NORMALS * NORMALS) * OFFSETS;
// What 1 is in the sums: 2048 samples of a workgroup that count up to 2 stay below 2^32.
const float UNIT = 524288.0;

// Offset at which a bin begins, world units.
float bin_offset(uint bin) {
    return dominant.forward.w * exp2((float(bin % OFFSETS) + FIRST) / PER_OCTAVE);
}

// Of a surface that faces the eye: its offset is negative.
uint bin_of(vec3 normal, float offset) {
    ivec3 n = clamp(ivec3(round(4.0 * normal)), ivec3(-4), ivec3(4)) + 4;
    float octave = log2(max(-offset, 1e-30) / dominant.forward.w);
    uint o = uint(clamp(floor(PER_OCTAVE * octave) - FIRST, 0.0, float(OFFSETS - 1u)));
    return uint((n.x * NORMALS + n.y) * NORMALS + n.z) * OFFSETS + o;
}
