#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/entry.glsl"

// Bakes the fallback into the page table: every node's entry names its own page or its nearest ancestor's.
layout(local_size_x = 256) in;
layout(constant_id = 0) const uint NODE_CAPACITY = 1024u;
layout(constant_id = 1) const uint TABLE_SIZE = 1024u;
layout(std430, binding = 0) buffer CountersBlock { Counters counters; };
layout(std430, binding = 1) readonly buffer Nodes { Node nodes[]; };
layout(std430, binding = 2) readonly buffer NodeList { uint node_list[]; };
layout(std430, binding = 3) readonly buffer Pages { Page pages[]; };
layout(std430, binding = 4) writeonly buffer Entries { uint entries[]; };
layout(std430, binding = 5) readonly buffer Slots { Slot slots[]; };
layout(std430, binding = 6) readonly buffer TableKeys { uint table_keys[]; };
layout(push_constant) uniform Push {
    int tolerance;  // levels by which a request may be served coarser before it counts as refused
};

#include "shared/table.glsl"

// The entry of a node's own page, or 0 when that cannot serve.
uint own_entry(uint index) {
    Node node = nodes[index];
    uvec2 key = table_key(index);
    int level = key_level(key);
    if (node.page != 0u) {
        Page page = pages[node.page - 1u];
        return page.admitted == 1u ? make_entry(level, page.turned, page.slot, page.dynamic_slot) : 0u;
    }
    // where the budgets put something off, whatever is still right serves; otherwise a frame shows what a first one would
    if (counters.draw_threshold == 0u && counters.deferred == 0u) {
        return 0u;
    }
    if (node.slot == 0u || (node.slot & STALE) != 0u || (node.marks & MARK_DYNAMIC) != 0u) {
        return 0u;
    }
    uint held = (node.slot & ~TURNED) - 1u;
    uint turned = (node.slot & TURNED) != 0u ? 1u : 0u;
    return slots[held].key == key && slots[held].valid != 0u ? make_entry(level, turned, held, NONE) : 0u;
}

void main() {
    uint end = min(counters.leaves + counters.nodes, NODE_CAPACITY);
    for (uint i = gl_GlobalInvocationID.x; i < end; i += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
        uint slot = node_list[i];
        int asked = key_level(table_key(slot));
        uint entry = own_entry(slot);
        uint parent = nodes[slot].parent;
        for (int step = 0; step < ROOT_LEVEL && entry == 0u && parent != 0u; step++) {
            entry = own_entry(parent - 1u);
            parent = nodes[parent - 1u].parent;
        }
        entries[slot] = entry;
        if (asked == ROOT_LEVEL && entry == 0u) {
            atomicAdd(counters.starved, 1u);
        }
        if (i < counters.leaves) {
            atomicAdd(counters.requested[asked], 1u);
            if (entry == 0u || entry_level(entry) > asked - int(counters.shift) + tolerance) {
                atomicAdd(counters.refused[asked], 1u);
            }
        }
    }
}
