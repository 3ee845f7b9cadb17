// Where one layer of a map lies: from coordinates across the light, divided by depth where the light has a position, to
// [0, 1]^2.
struct Fit {
    vec4 row_u;  // u = x * t.x + y * t.y + z
    vec4 row_v;
    vec4 texel;  // xy: size of a texel along u and v; 0 where the layer holds no sample
};
