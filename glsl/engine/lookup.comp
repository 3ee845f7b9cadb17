#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/light.glsl"
#include "shared/receiver.glsl"

// The full-screen mask: visibility of every pixel towards every light; 1 where there is no surface.
layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const uint TABLE_SIZE = 1024u;
layout(constant_id = 1) const uint GUTTER = 0u;
layout(constant_id = 2) const uint MASK_BITS = 32u;  // of a light: 1, 8 (fraction of 255) or 32 (a float)
layout(constant_id = 3) const bool SUN = false;
layout(constant_id = 4) const uint FILTER = 0u;
layout(constant_id = 5) const uint TAPS = 4u;
layout(constant_id = 6) const bool LEVEL_BLEND = false;
layout(constant_id = 7) const bool RANGED = false;  // whether `ranges` are known
layout(constant_id = 8) const bool EXACT = false;     // whether what the map cannot decide is left to rays
layout(constant_id = 9) const uint RAY_CAPACITY = 0u;
layout(constant_id = 10) const uint SAMPLES = 1u;     // of a pixel, with EXACT
layout(constant_id = 11) const float BEND = 0.0;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(binding = 1) uniform sampler2D depth_image;
layout(binding = 2) uniform usampler2D receiver_image;
layout(std430, binding = 3) readonly buffer TableKeys { uint table_keys[]; };
layout(std430, binding = 4) readonly buffer Entries { uint entries[]; };
layout(binding = 5) uniform sampler2DArray atlas;
layout(binding = 6, r32ui) writeonly uniform uimage2DArray mask_image;
layout(std430, binding = 7) readonly buffer Lights { Light lights[]; };
layout(std430, binding = 8) readonly buffer TileLights { uint tile_lights[]; };
layout(std430, binding = 9) readonly buffer Ranges { vec2 ranges[]; };
layout(std430, binding = 10) buffer RayCount { uint ray_count; };
layout(std430, binding = 11) writeonly buffer RayItems { uvec2 ray_items[]; };  // see exact_resolve.comp
layout(std430, binding = 12) writeonly buffer Rays { vec4 rays[]; };  // two each: receiver relative to the eye and t_max, direction and packed normal

#include "shared/light_receiver.glsl"
#include "shared/table.glsl"
#include "host/umbrage_lookup.glsl"
#include "host/umbrage_filter.glsl"
#include "shared/decide.glsl"
#include "shared/mask.glsl"

bool is_sun(Light light) { return SUN || light.kind.x == LIGHT_DIRECTIONAL; }

// Which part of a ball around a receiver a light reaches: all (MAP_LIT), nothing or some of it.
int light_reaches(Light light, vec3 from_eye, float radius) {
    if (is_sun(light)) {
        return MAP_LIT;
    }
    vec3 q = from_eye + light.eye.xyz;
    // towards the end of the cone this falls twice as fast as the distance at most
    float inside = min(light.place.w - length(q), 0.5 * (dot(light.axis_z.xyz, q) - light.eye.w * length(q)));
    return inside > radius ? MAP_LIT : inside < -radius ? MAP_SHADOWED : MAP_UNDECIDED;
}

// A receiver as the texels of the page that serves it see it.
struct View {
    Plane plane;
    uvec2 layers;
    vec2 dx;    // change of place per pixel, in texels
    vec2 dy;
    float rise; // stored depth for each length towards the light
    bool fine;  // for map_decides
};

// MAP_LOOK and the view, or what is known without.
int find_view(uint slot, Light light, vec3 from_eye, vec3 n, vec3 dx, vec3 dy, out View view) {
    Receiver r;
    if (!light_receiver(frame, light, from_eye, n, dx, dy, r)) {
        return MAP_SHADOWED;
    }
    if (!on_face(r.page)) {
        return MAP_LIT;
    }
    uint entry = umbrage_entry(key_of(r.level, slot * FACES + r.face, uvec2(r.page) >> r.level));
    float footprint = length(from_eye) * frame.ray_dy.w;
    float texel = r.unit * power_of_two(entry_level(entry)) / frame.rule.x;
    if (entry == 0u || !(texel <= MOST_PIXELS * footprint)) {
        return MAP_UNDECIDED;
    }
    float texels = frame.rule.x * power_of_two(-entry_level(entry));
    bool fine = SELF * light.rule.y <= footprint;
    float rise = is_sun(light) ? r.per_length : r.depth / length(from_eye + light.eye.xyz);
    view = View(umbrage_plane(light, r, entry), umbrage_layers(entry), texels * r.dx, texels * r.dy, rise, fine);
    return MAP_LOOK;
}

#include "shared/sub_sample.glsl"

// In which a light travels at a receiver.
vec3 way_of(Light light, vec3 from_eye) { return is_sun(light) ? light.axis_z.xyz : normalize(from_eye + light.eye.xyz); }

vec3 sample_point(uint i, Light light, vec3 from_eye, vec3 n, vec3 side_x, vec3 side_y) {
    return sub_sample(i, is_sun(light), is_sun(light) ? light.axis_z.xyz : light.eye.xyz, from_eye, n, side_x, side_y);
}

// What the map says of the samples of a pixel.
struct Samples {
    uint lit;    // how many certainly are
    uint asked;  // a bit for each that it leaves in doubt
    uint leans;  // a bit for each that is lit rather than not
};

void count_sample(uint i, int decision, bool leans, inout Samples samples) {
    samples.lit += uint(decision == MAP_LIT);
    samples.asked |= uint(decision == MAP_UNDECIDED) << i;
    samples.leans |= uint(leans) << i;
}

// All samples of a pixel by one page; false where they do not lie in one.
bool page_decides(uint slot, Light light, vec3 from_eye, vec3 n, vec3 side_x, vec3 side_y, inout Samples samples) {
    float farthest = 0.5 * (length(side_x) + length(side_y));
    int reached = light_reaches(light, from_eye, 2.0 * farthest);
    if (reached != MAP_LIT) {
        return reached == MAP_SHADOWED;
    }
    View view;
    int found = find_view(slot, light, from_eye, n, side_x, side_y, view);
    if (found != MAP_LOOK) {
        return found == MAP_SHADOWED;
    }
    Plane plane = view.plane;
    vec2 extent = 0.5 * (abs(view.dx) + abs(view.dy));
    vec2 last = vec2(textureSize(atlas, 0).xy) - 2.0;
    if (any(lessThan(plane.texel - extent, vec2(1.0))) || any(greaterThanEqual(plane.texel + extent, last + 1.0))) {
        return false;
    }
    // as many quads as the samples one by one take
    float rise = view.rise * towards_light(way_of(light, from_eye), n);
    int all = map_decides_all(plane, view.layers, view.fine, extent, rise * farthest, 2.0 * float(SAMPLES));
    samples.lit = all == MAP_LIT ? SAMPLES : 0u;
    for (uint i = 0u; i < SAMPLES && all == MAP_UNDECIDED; i++) {
        vec2 place = sample_place(i);
        vec2 shift = place.x * view.dx + place.y * view.dy;
        float depth = plane.depth + dot(plane.slope, shift) + rise * length(place.x * side_x + place.y * side_y);
        Plane at = Plane(plane.texel + shift, depth, plane.slope, plane.bias);
        bool leans;
        int decision = map_decides(at, view.layers, view.fine, leans);
        count_sample(i, decision, leans, samples);
    }
    return true;
}

// The share of a pixel's samples that the light reaches, or 0 and rays where the map cannot decide (frustum-traced shadows,
// Wyman, Hoetzlein and Lefohn 2015, take 32 samples of the pixel's quad on the receiver's plane).
float exact_visibility(uint slot, Light light, vec3 from_eye, vec3 n, vec3 dx, vec3 dy) {
    vec3 side_x = dx, side_y = dy;
    Samples samples = Samples(0u, 0u, 0u);
    bool decided = false;
    if (SAMPLES > 1u) {
        side_x = pixel_side(from_eye, n, dx);
        side_y = pixel_side(from_eye, n, dy);
        decided = page_decides(slot, light, from_eye, n, side_x, side_y, samples);
    }
    for (uint i = 0u; i < SAMPLES && !decided; i++) {
        View view;
        int decision = find_view(slot, light, sample_point(i, light, from_eye, n, side_x, side_y), n, side_x, side_y, view);
        bool leans = false;
        if (decision == MAP_LOOK) {
            decision = map_decides(view.plane, view.layers, view.fine, leans);
        }
        count_sample(i, decision, leans, samples);
    }
    uint asked = samples.asked;
    uint count = bitCount(asked);
    if (count == 0u) {
        return float(samples.lit) / float(SAMPLES);
    }
    // beyond the capacity nothing is counted, so that the count never wraps
    uint index = ray_count < RAY_CAPACITY ? atomicAdd(ray_count, count) : RAY_CAPACITY;
    bool room = index + count <= RAY_CAPACITY;
    uint packed = slot | samples.lit << 16 | count << 24;
    for (; asked != 0u; asked &= asked - 1u) {
        vec3 from = sample_point(uint(findLSB(asked)), light, from_eye, n, side_x, side_y);
        if (index < RAY_CAPACITY) {
            ray_items[index] = uvec2(gl_GlobalInvocationID.x | gl_GlobalInvocationID.y << 16, room ? packed : 0u);
            rays[2u * index] = vec4(from, is_sun(light) ? 1e30 : 1.0);
            rays[2u * index + 1u] = vec4(is_sun(light) ? -light.axis_z.xyz : -(from + light.eye.xyz), uintBitsToFloat(umbrage_encode_normal(n)));
        }
        packed = 0u;
        index++;
    }
    return room ? 0.0 : float(samples.lit + bitCount(samples.asked & samples.leans)) / float(SAMPLES);
}

float visibility_of(uint slot, Light light, vec3 from_eye, vec3 n, vec3 dx, vec3 dy) {
    if (FILTER != FILTER_HARD) {
        return umbrage_filtered(slot, light, from_eye, n, dx, dy, gl_GlobalInvocationID.xy);
    }
    return EXACT ? exact_visibility(slot, light, from_eye, n, dx, dy) : umbrage_visibility(slot, light, from_eye, n, dx, dy);
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, frame.size.xy))) {
        return;
    }
    float depth = texelFetch(depth_image, ivec2(pixel), 0).r;
    uvec4 receiver = texelFetch(receiver_image, ivec2(pixel), 0);
    vec3 from_eye = pixel_ray(frame, pixel) * depth;
    vec3 n = decode_normal(receiver.x);
    vec3 dx, dy;
    decode_derivatives(frame, receiver, depth, dx, dy);
    if (SUN) {
        // the words of the layers beyond the first light's are not read
        float visibility = depth > 0.0 ? visibility_of(0u, frame.sun, from_eye, n, dx, dy) : 1.0;
        imageStore(mask_image, ivec3(pixel, 0), uvec4(encode_visibility(visibility)));
        return;
    }
    uint words = (frame.lights.x + 31u) / 32u;
    uint tile = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * words;
    const uint in_layer = 32u / MASK_BITS;
    int layers = imageSize(mask_image).z;
    for (int layer = 0; layer < layers; layer++) {
        uint first = uint(layer) * in_layer;
        // bits of the lights of this layer
        uint bits = first < frame.lights.x ? tile_lights[tile + first / 32u] >> (first % 32u) : 0u;
        bits &= in_layer == 32u ? 0xffffffffu : (1u << in_layer) - 1u;
        uint word = 0u;
        if (depth <= 0.0) {
            word = MASK_BITS == 32u ? encode_visibility(1.0) : 0xffffffffu;
        } else {
            for (; bits != 0u; bits &= bits - 1u) {
                uint light = uint(findLSB(bits));
                word |= encode_visibility(visibility_of(first + light, lights[frame.size.w + first + light], from_eye, n, dx, dy)) << (light * MASK_BITS % 32u);
            }
        }
        imageStore(mask_image, ivec3(pixel, layer), uvec4(word));
    }
}
