#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/page_word.glsl"

// Debugging: what each layer of the atlas is to the last frame.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint SLOTS = 1024u;
layout(constant_id = 1) const uint CLEAR = 0u;  // word of the arguments: the draw over the layers drawn anew
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(std430, binding = 1) readonly buffer Slots { Slot slots[]; };
layout(std430, binding = 2) readonly buffer Cleared { uint cleared[]; };
layout(std430, binding = 3) readonly buffer Arguments { uint arguments[]; };
layout(std430, binding = 4) writeonly buffer States { uint states[]; };

void main() {
    uint slot = gl_GlobalInvocationID.x;
    if (slot >= SLOTS) {
        return;
    }
    uint state = LAYER_EMPTY;
    if (slots[slot].valid != 0u) {
        state = slots[slot].used == frame.cache.y ? LAYER_CACHED : LAYER_KEPT;
    }
    uint drawn = arguments[CLEAR + 1u];
    for (uint i = 0u; i < drawn; i++) {
        if (cleared[i] == slot) {
            state = LAYER_DRAWN;
        }
    }
    states[slot] = state;
}
