// For passes over the visible samples of each layer, in which a thread walks down ROWS pixels of a column, once for each layer that
// its workgroup meets. Needs sample.glsl.
const uint ROWS = 32u;
shared uint group_layers;  // bit i: the workgroup has samples of layer i

// Row r of the thread's column: false where there is no surface.
bool sample_of_row(uint r, out uvec2 pixel, out Sample s, out float depth) {
    pixel = uvec2(gl_GlobalInvocationID.x, gl_WorkGroupID.y * ROWS + r);
    depth = all(lessThan(pixel, frame.size.xy)) ? texelFetch(depth_image, ivec2(pixel), 0).r : 0.0;
    s = sample_at(pixel, depth);
    return depth > 0.0;
}

// Whether a layer must hold a sample.
bool belongs(Sample s, uint layer) { return s.layer == layer || s.next > 0.0 && s.layer + 1u == layer; }

// Fills group_layers; all threads of the workgroup take part, and meet at the end.
void find_layers() {
    if (gl_LocalInvocationIndex == 0u) {
        group_layers = LAYERS > 1u ? 0u : 1u;
    }
    barrier();
    if (LAYERS > 1u) {
        uint met = 0u;
        for (uint r = 0u; r < ROWS; r++) {
            uvec2 pixel;
            Sample s;
            float depth;
            if (sample_of_row(r, pixel, s, depth)) {
                met |= (s.next > 0.0 ? 3u : 1u) << s.layer;
            }
        }
        atomicOr(group_layers, met);
        barrier();
    }
}
