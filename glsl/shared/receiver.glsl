// Receivers: what the prepass and the gradient pass left for a pixel.

vec3 pixel_ray(Frame frame, uvec2 pixel) {
    vec2 centre = vec2(pixel) + 0.5;
    return frame.ray_corner.xyz + centre.x * frame.ray_dx.xyz + centre.y * frame.ray_dy.xyz;
}

// Distance along the view direction from a depth value of the camera's projection. Rounded values of few bits, or of a near plane
// close by, say it roughly: then the least that it may be, so that no surface lies before its receiver and shadows it.
float linear_depth(Frame frame, float depth) {
    float at = frame.ray_corner.w / (depth + frame.ray_dx.w);
    float moved = at * at / abs(frame.ray_corner.w) * (frame.eye_low.w + 1.2e-7 * abs(depth));
    // a few roundings of the distance itself are borne anyway
    return at - clamp(moved - 4.8e-7 * at, 0.0, 0.5 * at);
}

// Whether a depth value is that of a surface: not the far end of reversed (1 to 0) or of other (0 to 1) depth.
bool is_surface(Frame frame, float depth) { return frame.ray_corner.w > 0.0 ? depth > 0.0 : depth < 1.0; }

#include "host/umbrage_normal.glsl"

vec3 decode_normal(uint word) {
    vec2 p = unpackSnorm2x16(word);
    vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
    if (n.z < 0.0) {
        n.xy = (1.0 - abs(n.yx)) * vec2(n.x >= 0.0 ? 1.0 : -1.0, n.y >= 0.0 ? 1.0 : -1.0);
    }
    return normalize(n);
}

// World-space derivatives of the receiver's plane per pixel, from the packed receiver.
void decode_derivatives(Frame frame, uvec4 receiver, float depth, out vec3 dx, out vec3 dy) {
    vec2 a = unpackHalf2x16(receiver.y);
    vec2 b = unpackHalf2x16(receiver.z);
    vec2 c = unpackHalf2x16(receiver.w);
    float unit = depth * frame.ray_dy.w;
    dx = unit * vec3(a, b.x);
    dy = unit * vec3(b.y, c);
}

// How far along the normal a ray towards a light starts: 1e-5 of the diagonal of the casters' bounds, or, where a pixel is
// smaller than that, a hundredth of the pixel.
float ray_offset(Frame frame, vec3 from_eye) {
    float footprint = length(from_eye) * frame.ray_dy.w;
    return footprint < frame.rule.w ? 0.01 * footprint : frame.rule.w;
}

// Depth bias of a unit setting for a texel of this size; `slope`: change of the receiver's depth per texel along the
// map's axes. The plane at a texel's centre hides the receiver's own slope, but where another surface meets it in a
// concave edge the centre may lie on that; the difference grows with the texel and with the slope.
float receiver_bias(float texel, vec2 slope) { return texel + 0.25 * (abs(slope.x) + abs(slope.y)); }

// A receiver's plane in a layer of a map.
struct Plane {
    vec2 texel;   // of the receiver, from the layer's corner
    float depth;  // stored depth there, bias included
    vec2 slope;   // its change per texel
    float bias;   // contained in `depth`; 0 where nobody asks
};
