// The level rule: one function for request and lookup.
// RMSM (Lefohn et al. 2007, sec. 4): level = log2(sqrt(|dx x dy|)); min_length: log2(min(|dx|, |dy|)); in texels of level 0.

// dx, dy: light-space xy derivatives per pixel. The exponent of the squared length is read from the bits, so that the
// result is exact and equal on every device.
int footprint_level(Frame frame, vec2 dx, vec2 dy) {
    precise float squared;
    if (frame.size.z == 0u) {
        squared = abs(dx.x * dy.y - dx.y * dy.x);
    } else {
        precise float x = dx.x * dx.x + dx.y * dx.y;
        precise float y = dy.x * dy.x + dy.y * dy.y;
        squared = min(x, y);
    }
    precise float scaled = squared * frame.rule.x;
    int exponent = int((floatBitsToUint(scaled) >> 23) & 255u) - 127;
    return clamp(exponent >> 1, 0, ROOT_LEVEL);
}

// Light-space xy derivatives of a receiver.
void light_derivatives(Frame frame, vec3 dx, vec3 dy, out vec2 ls_dx, out vec2 ls_dy) {
    precise vec2 x = vec2(dot(frame.light_x.xyz, dx), dot(frame.light_y.xyz, dx));
    precise vec2 y = vec2(dot(frame.light_x.xyz, dy), dot(frame.light_y.xyz, dy));
    ls_dx = x;
    ls_dy = y;
}
