#version 460
#extension GL_GOOGLE_include_directive : require

// The warp of one axis from its importance (Rosen 2012, 4.2, steps ii and iii; equation 1 with its sum over the cells before a boundary
// set against that boundary, so that equal importance moves nothing), and its inverse at the map's texels. A workgroup an axis.
// Importance is summed up in whole numbers: the sums are exact, so the warp never runs backwards and does not depend on their order.
layout(local_size_x = 256) in;
layout(constant_id = 0) const uint CELLS = 512u;
layout(constant_id = 1) const uint SIDE = 2048u;
layout(constant_id = 2) const float SIGMA = 3.0;  // of the blur, in cells
layout(std430, binding = 0) readonly buffer Collapsed { uint collapsed[]; };
layout(std430, binding = 1) writeonly buffer RectilinearWarp { float warp[]; };
layout(std430, binding = 2) writeonly buffer Centres { vec2 centres[]; };  // as in rtw_centres.glsl

const uint GROUP = 256u;
const uint MOST_CELLS = 1024u;
const uint EACH = (CELLS + GROUP - 1u) / GROUP;  // cells of a thread
const float UNIT = 1048576.0;                    // the greatest importance as a whole number; 1024 of them fit

shared float raw[MOST_CELLS];
shared uint sums[MOST_CELLS + 1u];  // of the importance before each cell
shared uint parts[GROUP];
shared uint greatest;

// Gaussian over the cells that there are.
float blurred(uint cell) {
    if (SIGMA == 0.0) {
        return raw[cell];
    }
    int reach = int(ceil(3.0 * SIGMA));
    float sum = 0.0, weights = 0.0;
    for (int d = -reach; d <= reach; d++) {
        int at = int(cell) + d;
        if (at >= 0 && at < int(CELLS)) {
            float weight = exp(float(d * d) * (-0.5 / (SIGMA * SIGMA)));
            sum += weight * raw[at];
            weights += weight;
        }
    }
    return sum / weights;
}

// Where the map's coordinate `at` lies without the warp.
float unwarped(float at) {
    // the last cell that does not begin behind it; one without width is skipped
    float sought = at * float(sums[CELLS]);
    uint low = 0u, high = CELLS;
    while (high - low > 1u) {
        uint middle = (low + high) / 2u;
        if (float(sums[middle]) <= sought) {
            low = middle;
        } else {
            high = middle;
        }
    }
    float begin = float(sums[low]), end = float(sums[low + 1u]);
    return (float(low) + clamp((sought - begin) / max(end - begin, 1.0), 0.0, 1.0)) / float(CELLS);
}

void main() {
    uint axis = gl_WorkGroupID.x;
    uint local = gl_LocalInvocationIndex;
    for (uint i = local; i < CELLS; i += GROUP) {
        raw[i] = uintBitsToFloat(collapsed[axis * CELLS + i]);
    }
    if (local == 0u) {
        greatest = 0u;
    }
    barrier();
    float own[EACH];
    for (uint i = 0u; i < EACH; i++) {
        uint cell = local * EACH + i;
        own[i] = cell < CELLS ? blurred(cell) : 0.0;
        atomicMax(greatest, floatBitsToUint(own[i]));
    }
    barrier();
    // without any importance all cells are alike
    float scale = greatest == 0u ? 0.0 : UNIT / uintBitsToFloat(greatest);
    uint part = 0u;
    for (uint i = 0u; i < EACH; i++) {
        uint cell = local * EACH + i;
        uint whole = greatest == 0u ? 1u : own[i] > 0.0 ? max(uint(own[i] * scale + 0.5), 1u) : 0u;
        if (cell < CELLS) {
            sums[cell] = part;
            part += whole;
        }
    }
    parts[local] = part;
    barrier();
    uint before = 0u;
    for (uint i = 0u; i < local; i++) {
        before += parts[i];
    }
    for (uint i = 0u; i < EACH; i++) {
        uint cell = local * EACH + i;
        if (cell < CELLS) {
            sums[cell] += before;
        }
    }
    if (local == GROUP - 1u) {
        sums[CELLS] = before + part;
    }
    barrier();
    for (uint i = local; i <= CELLS; i += GROUP) {
        warp[axis * (CELLS + 1u) + i] = float(sums[i]) / float(sums[CELLS]);
    }
    for (uint i = local; i < SIDE; i += GROUP) {
        float begin = unwarped(float(i) / float(SIDE)), end = unwarped(float(i + 1u) / float(SIDE));
        centres[axis * SIDE + i] = vec2(unwarped((float(i) + 0.5) / float(SIDE)), end - begin);
    }
}
