#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/light.glsl"

// Turns each (cluster, page) pair into a draw: of the triangles that cover a texel centre of the page, compacted, or of
// the whole cluster where compaction gains nothing or its space is used up. One workgroup a pair.
layout(local_size_x_id = 4) in;
layout(constant_id = 0) const uint PAGE_TEXELS = 128u;
layout(constant_id = 1) const uint GUTTER = 0u;
layout(constant_id = 2) const uint PAIR_CAPACITY = 1024u;
layout(constant_id = 3) const uint INDEX_CAPACITY = 1024u;
layout(constant_id = 5) const uint POSITION_STRIDE = 3u;
layout(constant_id = 6) const uint POSITION_OFFSET = 0u;
layout(constant_id = 7) const uint POSITION_FORMAT = 0u;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(std430, binding = 1) buffer CountersBlock { Counters counters; };
layout(std430, binding = 2) readonly buffer Pages { Page pages[]; };
layout(std430, binding = 3) readonly buffer Pairs { Pair pairs[]; };
layout(std430, binding = 4) readonly buffer Clusters { Cluster clusters[]; };
layout(std430, binding = 5) readonly buffer Instances { Instance instances[]; };
layout(std430, binding = 6) readonly buffer Positions { uint positions[]; };
layout(std430, binding = 7) writeonly buffer Indices { uint indices[]; };  // the scene's, then room for compacted ones
layout(std430, binding = 8) writeonly buffer Commands { DrawCommand commands[]; };
layout(std430, binding = 9) readonly buffer Meshlets { uint meshlets[]; };  // see src/casters.rs
layout(std430, binding = 10) readonly buffer Lights { Light lights[]; };
layout(push_constant) uniform Push {
    uint masked;           // 1 for alpha-tested casters
    uint first_compacted;  // where the room for compacted indices begins
};

#include "shared/caster_bounds.glsl"
#include "shared/position.glsl"

const uint MAX_VERTICES = 384u;
const float BEHIND = 1e30;
shared vec2 texels_of[MAX_VERTICES];
shared uint kept[128];
shared uint kept_count;
shared uint kept_begin;

uvec3 corners(uint triangle) { return uvec3(triangle & 1023u, (triangle >> 10) & 1023u, triangle >> 20); }

// Whether the cluster lies inside the page and its triangles are so large that nearly all cover a texel centre.
bool draws_whole(Light light, Page page, Instance instance, Cluster cluster) {
    vec2 low, high;
    if (!face_bounds(light, key_face(page.key) % FACES, cluster_box(instance, cluster), low, high)) {
        return false;
    }
    float side = power_of_two(key_level(page.key));
    vec2 corner = vec2(key_page(page.key)) * side;
    low = (low - corner) * (frame.rule.x / side) + float(GUTTER);
    high = (high - corner) * (frame.rule.x / side) + float(GUTTER);
    vec2 size = high - low;
    return all(greaterThanEqual(low, vec2(0.0))) && all(lessThanEqual(high, vec2(float(PAGE_TEXELS)))) && size.x * size.y >= 4.0 * float(cluster.triangle_count);
}

void draw(uint index, uint first, uint count) {
    atomicAdd(counters.triangles, count / 3u);
    commands[index] = DrawCommand(count, count > 0u ? 1u : 0u, first, 0, index);
}

void main() {
    uint index = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (index >= (masked == 1u ? counters.pairs_masked : counters.pairs_opaque)) {
        return;
    }
    index += masked * PAIR_CAPACITY;
    uint local = gl_LocalInvocationIndex;
    Pair pair = pairs[index];
    Page page = pages[pair.target >> 1];
    if (page.admitted != 1u) {
        if (local == 0u) {
            draw(index, 0u, 0u);
        }
        return;
    }
    Cluster cluster = clusters[pair.cluster];
    Instance instance = instances[pair.instance];
    Light light = lights[key_face(page.key) / FACES];
    if (draws_whole(light, page, instance, cluster)) {
        if (local == 0u) {
            draw(index, cluster.first_index, 3u * cluster.triangle_count);
        }
        return;
    }
    if (local == 0u) {
        kept_count = 0u;
    }
    // rows from mesh space to texels of the page; of a face in perspective still to be divided by the third
    bool perspective = light.kind.x != LIGHT_DIRECTIONAL;
    vec4 rows[3] = vec4[3](instance.rows[0], instance.rows[1], instance.rows[2]);
    vec4 ls_rows[3];
    for (int i = 0; i < 4; i++) {
        vec3 ls = i == 3 ? vec3(pair.anchor[0], pair.anchor[1], pair.anchor[2]) : light_axes(light, vec3(rows[0][i], rows[1][i], rows[2][i]));
        ls = face_axes(perspective ? key_face(page.key) % FACES : 0u, ls);
        ls_rows[0][i] = ls.x;
        ls_rows[1][i] = ls.y;
        ls_rows[2][i] = ls.z;
    }
    vec4 row_w = perspective ? ls_rows[2] : vec4(0.0, 0.0, 0.0, 1.0);
    // the anchor of a directional light is relative to the origin already
    vec2 origin = perspective ? page.origin : vec2(0.0);
    vec4 row_x = page.scale * (ls_rows[0] - origin.x * row_w) + float(GUTTER) * row_w;
    vec4 row_y = page.scale * (ls_rows[1] - origin.y * row_w) + float(GUTTER) * row_w;
    uint vertices = meshlets[pair.cluster] + 1u;
    uint vertex_count = meshlets[vertices - 1u];
    for (uint v = local; v < vertex_count; v += gl_WorkGroupSize.x) {
        vec4 at = vec4(position(meshlets[vertices + v]), 1.0);
        float w = dot(row_w, at);
        // what comes too close to the light's plane is everywhere
        texels_of[v] = !perspective || w >= light.scale.z ? vec2(dot(row_x, at), dot(row_y, at)) / w : vec2(BEHIND);
    }
    barrier();
    float margin = texel_margin(key_level(page.key));
    if (!perspective) {
        // sums of the anchor and vectors of the cluster's length, here and in the vertex shader
        vec3 far = abs(vec3(cluster.center[0], cluster.center[1], cluster.center[2])) + vec3(cluster.extent[0], cluster.extent[1], cluster.extent[2]);
        margin = 1.0 / 64.0 + 1e-6 * max(dot(abs(row_x), vec4(far, 1.0)), dot(abs(row_y), vec4(far, 1.0)));
    }
    uint triangles = vertices + vertex_count;
    for (uint t = local; t < cluster.triangle_count; t += gl_WorkGroupSize.x) {
        uint triangle = meshlets[triangles + t];
        uvec3 c = corners(triangle);
        vec2 low = min(min(texels_of[c.x], texels_of[c.y]), texels_of[c.z]);
        vec2 high = max(max(texels_of[c.x], texels_of[c.y]), texels_of[c.z]);
        if (high.x >= BEHIND || !misses(low, high, margin)) {
            kept[atomicAdd(kept_count, 1u)] = triangle;
        }
    }
    barrier();
    if (local == 0u) {
        uint begin = 0u;
        bool whole = kept_count == cluster.triangle_count;
        if (!whole && kept_count > 0u) {
            begin = atomicAdd(counters.indices, 3u * kept_count);
            whole = begin + 3u * kept_count > INDEX_CAPACITY;
        }
        kept_begin = whole ? 0xffffffffu : first_compacted + begin;
        if (whole) {
            draw(index, cluster.first_index, 3u * cluster.triangle_count);
        } else {
            draw(index, kept_begin, 3u * kept_count);
        }
    }
    barrier();
    if (kept_begin != 0xffffffffu) {
        for (uint i = local; i < kept_count; i += gl_WorkGroupSize.x) {
            uvec3 c = corners(kept[i]);
            uint at = kept_begin + 3u * i;
            indices[at] = meshlets[vertices + c.x];
            indices[at + 1u] = meshlets[vertices + c.y];
            indices[at + 2u] = meshlets[vertices + c.z];
        }
    }
}
