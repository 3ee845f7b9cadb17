// Where a conventional map lies: from light-space xy relative to the eye to [0, 1]^2.
struct Fit {
    vec4 row_u;  // u = x * ls.x + y * ls.y + z
    vec4 row_v;
    vec4 texel;  // xy: world size of a texel along u and v
};
