// Visible samples as the light sees them, for passes over the image. Takes bindings 0 to 4.
layout(constant_id = 0) const uint LAYERS = 1u;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(binding = 1) uniform sampler2D depth_image;
layout(binding = 2) uniform usampler2D receiver_image;
#define LIGHT_BINDING 3
#include "methods/light.glsl"
#define SLICES_BINDING 4
#include "methods/slices.glsl"

layout(constant_id = 5) const float BLEND = 0.0;  // share of a slice at whose end its map gives way to the next one's

struct Sample {
    vec3 from_eye;
    vec3 normal;  // world space
    uint layer;   // cascade, face of the frustum or of a cube it belongs to
    float next;   // weight of the next cascade
};

// The face of the view frustum, in front of whose near plane no sample is, through which the light's line through a sample leaves it.
uint frustum_face(vec3 from_eye, float depth) {
    uint face = 0u;
    precise float least = exits[0].w * (depth - uintBitsToFloat(~extremes[1]));
    for (uint i = 1u; i < 5u; i++) {
        precise float way = dot(exits[i].xyz, from_eye) + exits[i].w;
        face = way < least ? i : face;
        least = min(way, least);
    }
    return face;
}

// The layer of a sample: the slice of depth, the face of the view frustum, or the face through which a light with a position sees it.
uint layer_of(vec3 from_eye, float depth) {
    if (LAYERS > 1u && exits[0].w != 0.0) {
        return frustum_face(from_eye, depth);
    }
    uint layer = 0u;
    float greatest = light_space(0u, from_eye).z;
    for (uint i = 1u; i < LAYERS; i++) {
        if (has_position()) {
            float z = light_space(i, from_eye).z;
            layer = z > greatest ? i : layer;
            greatest = max(z, greatest);
        } else {
            layer += depth >= splits[i] ? 1u : 0u;
        }
    }
    return layer;
}

float next_weight(uint layer, float depth) {
    if (BLEND == 0.0 || layer + 1u >= LAYERS) {
        return 0.0;
    }
    float band = BLEND * (splits[layer + 1u] - splits[layer]);
    return clamp((depth - splits[layer + 1u]) / max(band, 1e-30) + 1.0, 0.0, 1.0);
}

// All but the normal.
Sample sample_at(uvec2 pixel, float depth) {
    vec3 from_eye = pixel_ray(frame, pixel) * depth;
    uint layer = layer_of(from_eye, depth);
    return Sample(from_eye, vec3(0.0), layer, next_weight(layer, depth));
}

// Reads the normal. False where the light does not shine on the surface: turned away, beyond the range or outside the cone.
bool shone_on(uvec2 pixel, inout Sample s) {
    s.normal = decode_normal(texelFetch(receiver_image, ivec2(pixel), 0).x);
    if (!has_position()) {
        return dot(s.normal, light.faces[0].z.xyz) < 0.0;
    }
    vec3 p = light_space(0u, s.from_eye);
    float away = length(p);
    return dot(turned(0u, s.normal), p) < 0.0 && away <= light.rule.z && p.z >= light.rule.w * away;
}

layout(constant_id = 9) const uint SAMPLES = 1u;  // of a pixel
layout(constant_id = 10) const float BEND = 0.0;   // see sub_sample.glsl
#include "shared/sub_sample.glsl"

// Sample i of a pixel, after `shone_on`.
vec3 sample_point(uint i, uvec2 pixel, float depth, Sample s) {
    vec3 dx = vec3(0.0), dy = vec3(0.0);
    if (SAMPLES > 1u) {
        decode_derivatives(frame, texelFetch(receiver_image, ivec2(pixel), 0), depth, dx, dy);
        dx = pixel_side(s.from_eye, s.normal, dx);
        dy = pixel_side(s.from_eye, s.normal, dy);
    }
    Face face = light.faces[0];
    vec3 eye = face.x.w * face.x.xyz + face.y.w * face.y.xyz + face.z.w * face.z.xyz;
    return sub_sample(i, !has_position(), has_position() ? eye : face.z.xyz, s.from_eye, s.normal, dx, dy);
}

// Where a ray from there starts: off the surface by `ray_offset`, which is 0 for methods that do not ask for it.
vec3 ray_start(vec3 point, Sample s) { return point + ray_offset(frame, s.from_eye) * s.normal; }
