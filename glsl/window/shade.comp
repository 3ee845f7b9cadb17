#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/receiver.glsl"
#include "shared/key.glsl"
#include "shared/page_word.glsl"
#include "window/palette.glsl"

// What the window shows of each pixel: the view under its lights as src/output/shade.rs has it, or an inner state in false
// colours, sRGB encoded.
layout(local_size_x = 8, local_size_y = 8) in;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(binding = 1) uniform sampler2D depth_image;
layout(binding = 2) uniform usampler2D normal_image;
layout(binding = 3) uniform sampler2D albedo_image;
layout(std430, binding = 4) readonly buffer Visibility { uint visibility[]; };  // images of a word a pixel, `bits` a light
layout(std430, binding = 5) readonly buffer Lights { ShadeLight lights[]; };
layout(std430, binding = 6) readonly buffer Palette { vec4 palette[]; };
layout(std430, binding = 7) readonly buffer Pages { uint pages[]; };
layout(binding = 8, rgba8) writeonly uniform image2D target_image;
layout(push_constant) uniform Push {
    vec4 up;      // unit vector; w: brightness of the sky
    uint count;   // of lights
    uint bits;    // of a light's visibility: 32 is a float
    uint show;    // SHOW_*
    float sun_at; // share of its range at which a light with a place is as bright as the sun
};

const uint SHOW_SHADED = 0u;
const uint SHOW_VISIBILITY = 1u;
const uint SHOW_LEVEL = 2u;
const uint SHOW_PAGE = 3u;
const uint SHOW_STATE = 4u;

float visible(uint light, uint pixel) {
    uint at = light * bits;
    uint word = visibility[at / 32u * (frame.size.x * frame.size.y) + pixel];
    uint most = (1u << (bits & 31u)) - 1u;
    return bits == 32u ? clamp(uintBitsToFloat(word), 0.0, 1.0) : float(word >> at % 32u & most) / float(most);
}

// n.l times the brightness of an unshadowed light, 1 for the sun; the falloff of KHR_lights_punctual.
float received(ShadeLight light, vec3 from_eye, vec3 n) {
    vec3 to_light = light.direction.w == LIGHT_SUN ? -light.direction.xyz : light.place.xyz - from_eye;
    float far = length(to_light);
    vec3 l = far > 0.0 ? to_light / far : vec3(0.0);
    float lambert = max(dot(n, l), 0.0);
    if (light.direction.w == LIGHT_SUN) {
        return lambert;
    }
    float cone = 1.0;
    if (light.direction.w == LIGHT_CONE) {
        float inside = clamp((-dot(l, light.direction.xyz) - light.cone.y) / max(light.cone.x - light.cone.y, 1e-3), 0.0, 1.0);
        cone = inside * inside;
    }
    float share = far / light.place.w;
    float square = share * share;
    float falloff = sun_at / max(share, 1e-3);
    return lambert * cone * clamp(1.0 - square * square, 0.0, 1.0) * falloff * falloff;
}

vec3 sky(float height) {
    vec3 horizon = palette[SKY_HORIZON].rgb;
    return height < 0.0 ? mix(horizon, palette[SKY_GROUND].rgb, min(-8.0 * height, 1.0)) : mix(horizon, palette[SKY_ZENITH].rgb, sqrt(height));
}

// Narkowicz's fit of the ACES film curve (2015), then the sRGB curve.
vec3 tone(vec3 color) {
    vec3 x = color * 0.62;
    vec3 film = clamp((x * (x * 2.51 + 0.03)) / (x * (x * 2.43 + 0.59) + 0.14), 0.0, 1.0);
    return mix(1.055 * pow(film, vec3(1.0 / 2.4)) - 0.055, 12.92 * film, lessThanEqual(film, vec3(0.0031308)));
}

// Colours of inner states: dimmed where it is dark, so that the place stays in sight.
vec3 inner(uint word, float lit) {
    // surfaces that ask for nothing are told from the sky
    vec3 color = 2.0 * palette[NOTHING].rgb;
    if (word != 0u) {
        switch (show) {
        case SHOW_LEVEL:
            color = palette[LEVELS_FIRST + word_level(word) % LEVEL_COLORS].rgb;
            break;
        case SHOW_PAGE:
            uint h = hash(word_slot(word) + 1u);
            color = 0.25 + 0.75 * vec3(h & 255u, h >> 8 & 255u, h >> 16 & 255u) / 255.0;
            break;
        default:
            color = word_coarser(word) ? palette[STATE_COARSER].rgb : palette[word_state(word) == LAYER_DRAWN ? STATE_DRAWN : STATE_CACHED].rgb;
        }
        color *= 0.45 + 0.55 * min(lit, 1.0);
    }
    return color;
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, frame.size.xy))) {
        return;
    }
    uint index = pixel.y * frame.size.x + pixel.x;
    float stored = texelFetch(depth_image, ivec2(pixel), 0).r;
    vec3 ray = pixel_ray(frame, pixel);
    vec3 color;
    if (stored <= 0.0) {
        bool outside = show == SHOW_SHADED;
        color = outside ? tone(sky(dot(normalize(ray), up.xyz)) * up.w) : palette[NOTHING].rgb;
    } else {
        vec3 from_eye = ray * linear_depth(frame, stored);
        vec3 n = decode_normal(texelFetch(normal_image, ivec2(pixel), 0).r);
        float lit = 0.0;
        float most = 0.0;
        for (uint i = 0u; i < count; i++) {
            float v = visible(i, index);
            lit += received(lights[i], from_eye, n) * v;
            most = max(most, v);
        }
        if (show == SHOW_SHADED) {
            vec3 ambient = mix(palette[GROUND_AMBIENT].rgb, palette[SKY_AMBIENT].rgb, 0.5 + 0.5 * dot(n, up.xyz));
            color = tone(texelFetch(albedo_image, ivec2(pixel), 0).rgb * (ambient * up.w + palette[SUN].rgb * lit));
        } else if (show == SHOW_VISIBILITY) {
            color = vec3(most);
        } else {
            color = inner(pages[index], lit);
        }
    }
    imageStore(target_image, ivec2(pixel), vec4(color, 1.0));
}
