#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"

// Turns each (cluster, page) pair into a draw: of the triangles that cover a texel centre of the page, compacted, or of
// the whole cluster where compaction gains nothing or its space is used up. One workgroup a pair.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint PAGE_TEXELS = 128u;
layout(constant_id = 1) const uint GUTTER = 0u;
layout(constant_id = 2) const uint PAIR_CAPACITY = 1024u;
layout(constant_id = 3) const uint INDEX_CAPACITY = 1024u;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(std430, binding = 1) buffer CountersBlock { Counters counters; };
layout(std430, binding = 2) readonly buffer Pages { Page pages[]; };
layout(std430, binding = 3) readonly buffer Pairs { Pair pairs[]; };
layout(std430, binding = 4) readonly buffer Casters { Caster casters[]; };
layout(std430, binding = 5) readonly buffer Clusters { Cluster clusters[]; };
layout(std430, binding = 6) readonly buffer Instances { Instance instances[]; };
layout(std430, binding = 7) readonly buffer Positions { float positions[]; };
layout(std430, binding = 8) buffer Indices { uint indices[]; };  // the scene's, then room for compacted ones
layout(std430, binding = 9) writeonly buffer Commands { DrawCommand commands[]; };
layout(push_constant) uniform Push {
    uint masked;           // 1 for alpha-tested casters
    uint first_compacted;  // where the room for compacted indices begins
};


shared uint kept[384];
shared uint kept_count;
shared uint kept_begin;

float texel_margin(int level) { return 1.0 / 64.0 + 0.25 * exp2(-float(level)); }

void main() {
    uint index = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (index >= (masked == 1u ? counters.pairs_masked : counters.pairs_opaque)) {
        return;
    }
    index += masked * PAIR_CAPACITY;
    uint local = gl_LocalInvocationIndex;
    if (local == 0u) {
        kept_count = 0u;
    }
    barrier();
    Page page = pages[pairs[index].page];
    Caster caster = casters[pairs[index].caster];
    Cluster cluster = clusters[caster.cluster];
    Instance instance = instances[caster.instance];
    // rows from mesh space to texels of the page
    vec4 row_x = frame.light_x.x * instance.rows[0] + frame.light_x.y * instance.rows[1] + frame.light_x.z * instance.rows[2];
    vec4 row_y = frame.light_y.x * instance.rows[0] + frame.light_y.y * instance.rows[1] + frame.light_y.z * instance.rows[2];
    row_x = page.scale * (row_x - vec4(0.0, 0.0, 0.0, page.origin.x)) + vec4(0.0, 0.0, 0.0, float(GUTTER));
    row_y = page.scale * (row_y - vec4(0.0, 0.0, 0.0, page.origin.y)) + vec4(0.0, 0.0, 0.0, float(GUTTER));
    float margin = texel_margin(key_level(page.key));
    for (uint t = local; t < cluster.triangle_count; t += 64u) {
        uint at = cluster.first_index + 3u * t;
        uvec3 corner = uvec3(indices[at], indices[at + 1u], indices[at + 2u]);
        vec2 texel[3];
        for (int i = 0; i < 3; i++) {
            uint p = 3u * corner[i];
            vec4 position = vec4(positions[p], positions[p + 1u], positions[p + 2u], 1.0);
            texel[i] = vec2(dot(row_x, position), dot(row_y, position));
        }
        vec2 low = min(min(texel[0], texel[1]), texel[2]);
        vec2 high = max(max(texel[0], texel[1]), texel[2]);
        vec2 first = max(ceil(low - 0.5 - margin), vec2(0.0));
        vec2 last = min(floor(high - 0.5 + margin), vec2(float(PAGE_TEXELS - 1u)));
        if (all(lessThanEqual(first, last))) {
            uint slot = 3u * atomicAdd(kept_count, 1u);
            kept[slot] = corner.x;
            kept[slot + 1u] = corner.y;
            kept[slot + 2u] = corner.z;
        }
    }
    barrier();
    if (local == 0u) {
        uint begin = 0u;
        uint count = 3u * kept_count;
        bool whole = kept_count == cluster.triangle_count;
        if (!whole && count > 0u) {
            begin = atomicAdd(counters.indices, count);
            whole = begin + count > INDEX_CAPACITY;
        }
        begin += first_compacted;
        if (whole) {
            begin = cluster.first_index;
            count = 3u * cluster.triangle_count;
        }
        kept_begin = whole ? 0xffffffffu : begin;
        atomicAdd(counters.triangles, count / 3u);
        commands[index] = DrawCommand(count, count > 0u ? 1u : 0u, begin, 0, index);
    }
    barrier();
    if (kept_begin != 0xffffffffu) {
        for (uint i = local; i < 3u * kept_count; i += 64u) {
            indices[kept_begin + i] = kept[i];
        }
    }
}
