#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/receiver.glsl"
#include "shared/level.glsl"
#include "shared/key.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const uint TABLE_SIZE = 1024u;
layout(constant_id = 1) const bool FLAGS = true;  // route: into the page table at once, or append for the sort
layout(constant_id = 2) const uint CAPACITY = 1024u;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(binding = 1) uniform sampler2D depth_image;
layout(binding = 2) uniform usampler2D receiver_image;
layout(std430, binding = 3) buffer CountersBlock { Counters counters; };
layout(std430, binding = 4) buffer TableKeys { uint table_keys[]; };
layout(std430, binding = 5) buffer Nodes { Node nodes[]; };
layout(std430, binding = 6) writeonly buffer NodeList { uint node_list[]; };
layout(std430, binding = 7) writeonly buffer Keys { uint keys[]; };
layout(std430, binding = 8) writeonly buffer Values { uint values[]; };
layout(push_constant) uniform Push {
    uint attempt;
    uint shift;  // levels by which every request is coarsened
};

#include "shared/table.glsl"
#include "shared/table_insert.glsl"

// de-duplication inside the workgroup: a hash table twice the size of the group
const uint SHARED = 128u;
shared uint shared_keys[SHARED];
shared uint shared_counts[SHARED];

// The page a pixel asks for, or 0 when it needs none: no surface, facing away from the light, or beyond all casters.
uint request_key(uvec2 pixel) {
    if (any(greaterThanEqual(pixel, frame.size.xy))) {
        return 0u;
    }
    float stored = texelFetch(depth_image, ivec2(pixel), 0).r;
    if (stored <= 0.0) {
        return 0u;
    }
    uvec4 receiver = texelFetch(receiver_image, ivec2(pixel), 0);
    if (dot(decode_normal(receiver.x), frame.light_z.xyz) >= 0.0) {
        return 0u;
    }
    float depth = linear_depth(frame, stored);
    ivec2 page;
    vec2 inside;
    light_page(frame, pixel_ray(frame, pixel) * depth, page, inside);
    if (!on_grid(page)) {
        return 0u;
    }
    vec3 dx, dy;
    vec2 ls_dx, ls_dy;
    decode_derivatives(frame, receiver, depth, dx, dy);
    light_derivatives(frame, dx, dy, ls_dx, ls_dy);
    int level = min(footprint_level(frame, ls_dx, ls_dy) + int(shift), ROOT_LEVEL);
    return key_of(level, uvec2(page) >> level);
}

void emit(uint key, uint count) {
    if (FLAGS) {
        // this attempt has failed already: what it would still insert is wiped anyway
        if (counters.requests[attempt] > CAPACITY) {
            return;
        }
        bool fresh;
        uint slot = table_insert(key, fresh);
        if (slot == NONE) {
            atomicAdd(counters.failed, 1u);
            return;
        }
        if (fresh) {
            uint index = atomicAdd(counters.requests[attempt], 1u);
            if (index < CAPACITY) {
                node_list[index] = slot;
                nodes[slot].key = key;
            }
        }
        atomicAdd(nodes[slot].own, count);
    } else {
        uint index = atomicAdd(counters.requests[attempt], 1u);
        if (index < CAPACITY) {
            keys[index] = key;
            values[index] = count;
        }
    }
}

void main() {
    uint local = gl_LocalInvocationIndex;
    for (uint i = local; i < SHARED; i += 64u) {
        shared_keys[i] = 0u;
        shared_counts[i] = 0u;
    }
    barrier();
    uint key = request_key(gl_GlobalInvocationID.xy);
    if (key != 0u) {
        uint slot = (key * 0x9e3779b1u) >> 25;
        for (uint i = 0u; i < SHARED; i++) {
            uint stored = shared_keys[slot];
            if (stored == 0u) {
                stored = atomicCompSwap(shared_keys[slot], 0u, key);
            }
            if (stored == 0u || stored == key) {
                atomicAdd(shared_counts[slot], 1u);
                break;
            }
            slot = (slot + 1u) & (SHARED - 1u);
        }
    }
    barrier();
    for (uint i = local; i < SHARED; i += 64u) {
        if (shared_keys[i] != 0u) {
            emit(shared_keys[i], shared_counts[i]);
        }
    }
}
