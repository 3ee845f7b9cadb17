#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/light.glsl"
#include "shared/receiver.glsl"
#include "shared/morton.glsl"

// The pages that the pixels of one view ask for, and the lights that reach each tile of 8x8 pixels.
layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const uint TABLE_SIZE = 1024u;
layout(constant_id = 1) const bool FLAGS = true;  // route: into the page table at once, or append for the sort
layout(constant_id = 2) const uint CAPACITY = 1024u;
layout(constant_id = 3) const bool SUN = false;
layout(constant_id = 4) const bool LEVEL_BLEND = false;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(binding = 1) uniform sampler2D depth_image;
layout(binding = 2) uniform usampler2D receiver_image;
layout(std430, binding = 3) buffer CountersBlock { Counters counters; };
layout(std430, binding = 4) buffer TableKeys { uint table_keys[]; };
layout(std430, binding = 5) buffer Nodes { Node nodes[]; };
layout(std430, binding = 6) writeonly buffer NodeList { uint node_list[]; };
layout(std430, binding = 7) writeonly buffer Keys { uvec2 keys[]; };
layout(std430, binding = 8) writeonly buffer Values { uint values[]; };
layout(std430, binding = 9) readonly buffer Lights { Light lights[]; };
layout(std430, binding = 10) writeonly buffer TileLights { uint tile_lights[]; };  // a bit for each light, tile by tile
layout(push_constant) uniform Push {
    uint attempt;
    uint shift;  // levels by which every request is coarsened
};

#include "shared/light_receiver.glsl"
#include "shared/table.glsl"
#include "shared/table_insert.glsl"
#include "shared/tile_box.glsl"

// de-duplication inside the workgroup; what finds no place within a few probes is emitted at once
const uint SHARED = 128u;
const uint SHARED_PROBES = 32u;
shared uint shared_x[SHARED];
shared uint shared_y[SHARED];  // complement, as in the page table
shared uint shared_counts[SHARED];

void emit(uvec2 key, uint count) {
    if (FLAGS) {
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
            }
        }
        atomicAdd(nodes[slot].own, count);
    } else {
        uint index = atomicAdd(counters.requests[attempt], 1u);
        if (index < CAPACITY) {
            keys[index] = key_to_morton(key);
            values[index] = count;
        }
    }
}

// As table_insert, into shared memory.
void gather(uvec2 key) {
    uint slot = key_hash(key) % SHARED;
    uint word = ~key.y;
    for (uint i = 0u; i < SHARED_PROBES; i++) {
        uint stored = shared_x[slot];
        if (stored == 0u) {
            stored = atomicCompSwap(shared_x[slot], 0u, key.x);
        }
        if (stored == 0u || stored == key.x) {
            stored = shared_y[slot];
            if (stored == 0u) {
                stored = atomicCompSwap(shared_y[slot], 0u, word);
            }
            if (stored == 0u || stored == word) {
                atomicAdd(shared_counts[slot], 1u);
                return;
            }
        }
        slot = (slot + 1u) % SHARED;
    }
    emit(key, 1u);
}

// Asks for the page of a receiver, and for the coarser one with which it is blended.
void ask(uint slot, Light light, vec3 from_eye, vec3 n, vec3 dx, vec3 dy) {
    Receiver r;
    if (light_receiver(frame, light, from_eye, n, dx, dy, r) && on_face(r.page)) {
        int level = min(r.level + int(shift), ROOT_LEVEL);
        gather(key_of(level, slot * FACES + r.face, uvec2(r.page) >> level));
        if (LEVEL_BLEND && r.coarser > 0.0 && level < ROOT_LEVEL) {
            gather(key_of(level + 1, slot * FACES + r.face, uvec2(r.page) >> (level + 1)));
        }
    }
}

void main() {
    // later attempts have as many groups as the largest view
    if (any(greaterThanEqual(8u * gl_WorkGroupID.xy, frame.size.xy))) {
        return;
    }
    uint local = gl_LocalInvocationIndex;
    for (uint i = local; i < SHARED; i += 64u) {
        shared_x[i] = 0u;
        shared_y[i] = 0u;
        shared_counts[i] = 0u;
    }
    uvec2 pixel = gl_GlobalInvocationID.xy;
    float depth = 0.0;
    if (all(lessThan(pixel, frame.size.xy))) {
        depth = texelFetch(depth_image, ivec2(pixel), 0).r;
    }
    vec3 from_eye = pixel_ray(frame, pixel) * depth;
    uint words = light_words(frame);
    if (!SUN) {
        find_tile_lights(depth, depth > 0.0);
        barrier();
        uint tile = (gl_WorkGroupID.y * ((frame.size.x + 7u) / 8u) + gl_WorkGroupID.x) * words;
        for (uint i = local; i < words; i += 64u) {
            tile_lights[tile + i] = box_lights[i];
        }
    } else {
        barrier();
    }
    // an attempt that has failed already need not go on: what it finds is wiped anyway
    if (depth > 0.0 && !(FLAGS && counters.requests[attempt] > CAPACITY)) {
        uvec4 receiver = texelFetch(receiver_image, ivec2(pixel), 0);
        vec3 n = decode_normal(receiver.x);
        vec3 dx, dy;
        decode_derivatives(frame, receiver, depth, dx, dy);
        if (SUN) {
            ask(0u, frame.sun, from_eye, n, dx, dy);
        }
        for (uint i = 0u; !SUN && i < words; i++) {
            for (uint bits = box_lights[i]; bits != 0u; bits &= bits - 1u) {
                uint slot = 32u * i + uint(findLSB(bits));
                ask(slot, lights[frame.size.w + slot], from_eye, n, dx, dy);
            }
        }
    }
    barrier();
    for (uint i = local; i < SHARED; i += 64u) {
        if (shared_counts[i] != 0u) {
            emit(uvec2(shared_x[i], ~shared_y[i]), shared_counts[i]);
        }
    }
}
