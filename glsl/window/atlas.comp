#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"
#include "shared/page_word.glsl"
#include "window/palette.glsl"

// The physical atlas: a cell for each layer, its depths tinted by the page's level, with a frame in the colour of its state;
// layers kept for later frames are dim.
layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const uint SLOTS = 1024u;
layout(binding = 0) uniform sampler2DArray atlas;
layout(std430, binding = 1) readonly buffer Slots { Slot slots[]; };
layout(std430, binding = 2) readonly buffer States { uint states[]; };
layout(std430, binding = 3) readonly buffer Palette { vec4 palette[]; };
layout(binding = 4, rgba8) writeonly uniform image2D target_image;
layout(push_constant) uniform Push {
    uint columns;
    uint cell;  // side in pixels
};

// A layer's depths between the nearest and the farthest of a few of them.
float contrast(int layer, float depth) {
    int side = textureSize(atlas, 0).x;
    float low = 1.0;
    float high = 0.0;
    for (int i = 0; i < 16; i++) {
        float at = texelFetch(atlas, ivec3((2 * i % 8 + 1) * side / 8, (2 * (i / 4) + 1) * side / 8, layer), 0).r;
        low = at > 0.0 ? min(low, at) : low;
        high = max(high, at);
    }
    return depth > 0.0 ? 0.35 + 0.65 * clamp((depth - low) / max(high - low, 1e-9), 0.0, 1.0) : 0.15;
}

vec3 layer_color(uint slot, uvec2 inside) {
    uint state = states[slot];
    if (state == LAYER_EMPTY) {
        return 1.5 * palette[NOTHING].rgb;
    }
    vec3 edge = palette[state == LAYER_DRAWN ? STATE_DRAWN : STATE_CACHED].rgb;
    float dim = state == LAYER_KEPT ? 0.3 : 1.0;
    if (any(equal(inside, uvec2(0u)))) {
        return edge * dim;
    }
    uint side = uint(textureSize(atlas, 0).x);
    uvec2 key = slots[slot].key;
    // layers of moving casters have no page of their own
    vec3 tint = key.x == 0u ? vec3(0.8) : palette[LEVELS_FIRST + uint(key_level(key)) % LEVEL_COLORS].rgb;
    float depth = texelFetch(atlas, ivec3(inside * side / cell, slot), 0).r;
    return tint * dim * contrast(int(slot), depth);
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, uvec2(imageSize(target_image))))) {
        return;
    }
    uvec2 place = pixel / cell;
    uint slot = place.y * columns + place.x;
    vec3 color = place.x < columns && slot < SLOTS ? layer_color(slot, pixel % cell) : palette[NOTHING].rgb;
    imageStore(target_image, ivec2(pixel), vec4(color, 1.0));
}
