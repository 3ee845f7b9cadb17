// A rectilinear warp (Rosen 2012, sec. 3): two maps of one dimension, one for each axis of a map, each a polyline over CELLS cells
// of equal width. The includer defines CELLS_CONSTANT and WARP_BINDING.
layout(constant_id = CELLS_CONSTANT) const uint CELLS = 512u;
layout(std430, binding = WARP_BINDING) readonly buffer RectilinearWarp { float warp[]; };  // where cells begin and the last ends: CELLS + 1 along u, then along v

// Where the map has a coordinate of the fit; beyond [0, 1], as without a warp.
float warped(uint axis, float at) {
    if (!(at > 0.0 && at < 1.0)) {
        return at;
    }
    precise float cells = at * float(CELLS);
    precise float cell = min(floor(cells), float(CELLS - 1u));
    uint i = axis * (CELLS + 1u) + uint(cell);
    precise float low = warp[i], high = warp[i + 1u];
    precise float place = low + (high - low) * (cells - cell);
    return clamp(place, low, high);
}

// Change of that per change of the coordinate, in [0, 1].
float growth(uint axis, float at) {
    uint i = axis * (CELLS + 1u) + min(uint(at * float(CELLS)), CELLS - 1u);
    return (warp[i + 1u] - warp[i]) * float(CELLS);
}

vec2 warped(vec2 at) { return vec2(warped(0u, at.x), warped(1u, at.y)); }
