#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/light.glsl"

// Finds the cached pages in this frame's quadtree.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint TABLE_SIZE = 1024u;
layout(constant_id = 1) const uint SLOTS = 1024u;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(std430, binding = 1) readonly buffer TableKeys { uint table_keys[]; };
layout(std430, binding = 2) buffer Nodes { Node nodes[]; };
layout(std430, binding = 3) buffer Slots { Slot slots[]; };
layout(std430, binding = 4) readonly buffer Lights { Light lights[]; };

#include "shared/table.glsl"
#include "shared/drift.glsl"

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= SLOTS || slots[index].key.x == 0u) {
        return;
    }
    uint node = table_find(slots[index].key);
    if (node != NONE) {
        Light light = lights[key_face(slots[index].key) / FACES];
        nodes[node].slot = (index + 1u) | (slots[index].valid != 0u ? 0u : STALE) | (drift(light, slots[index]) > 0.0 ? TURNED : 0u);
        slots[index].seen = frame.cache.y;
    }
}
