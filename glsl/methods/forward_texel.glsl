// The surface that a texel of the map sees, and where the image has it. Bindings 0 to 3; needs frame.glsl, fit.glsl and forward.glsl.
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
#define LIGHT_BINDING 1
#include "methods/light.glsl"
#include "methods/stored_z.glsl"
layout(std430, binding = 2) readonly buffer Fits { Fit fits[]; };
layout(binding = 3) uniform sampler2DArray map;
layout(constant_id = 3) const float STRETCH = 16.0;  // greatest change of z to the next texel, in sides of the texel

// Texels beyond the kernel's radius that a splat covers, since its place in the image is rounded.
const float MARGIN = 1.0 / 16.0;

struct Surfel {
    float depth;   // as stored; 0 where the texel sees nothing
    vec2 slope;    // its change to the next texel along u and v
    mat2 t_of_uv;
    uint face;
};

float seen(ivec3 texel) {
    bool inside = all(greaterThanEqual(texel.xy, ivec2(0))) && all(lessThan(texel.xy, textureSize(map, 0).xy));
    return inside ? texelFetch(map, texel, 0).r : 0.0;
}

// The lesser of the changes from one neighbour and to the other: the texel's own surface goes on at least to one side.
float change(float depth, float before, float after) {
    float from = before > 0.0 ? depth - before : 1e30;
    float to = after > 0.0 ? after - depth : 1e30;
    float least = abs(from) < abs(to) ? from : to;
    return least < 1e30 ? least : 0.0;
}

Surfel surfel_of(ivec3 texel) {
    Fit fit = fits[texel.z];
    Surfel s;
    s.depth = seen(texel);
    s.face = face_of(texel.z);
    s.t_of_uv = inverse(transpose(mat2(fit.row_u.xy, fit.row_v.xy)));
    s.slope = vec2(change(s.depth, seen(texel - ivec3(1, 0, 0)), seen(texel + ivec3(1, 0, 0))),
                   change(s.depth, seen(texel - ivec3(0, 1, 0)), seen(texel + ivec3(0, 1, 0))));
    float z = z_of(s.depth);
    float per_z = has_position() ? light.depth.y / (z * z) : abs(light.depth.x);
    mat2 sides = s.t_of_uv * (divisor(z) / float(textureSize(map, 0).x));
    vec2 most = STRETCH * per_z * vec2(length(sides[0]), length(sides[1]));
    s.slope = clamp(s.slope, -most, most);
    return s;
}

// A corner of the splat in clip space; all depths are within its range. `sign`: which.
vec4 splat_corner(ivec3 texel, Surfel s, vec2 sign) {
    Fit fit = fits[texel.z];
    vec2 away = sign * (float(REACH) / 256.0 + MARGIN);
    vec2 uv = (vec2(texel.xy) + 0.5 + away) / float(textureSize(map, 0).x);
    float depth = s.depth + dot(s.slope, away);
    // in front of infinity
    float z = z_of(has_position() ? max(depth, 0.1 * s.depth) : depth);
    vec2 t = s.t_of_uv * (uv - vec2(fit.row_u.z, fit.row_v.z));
    vec3 ls = vec3(divisor(z) * t, z);
    Face face = light.faces[s.face];
    ls -= vec3(face.x.w, face.y.w, face.z.w);
    vec3 from_eye = ls.x * face.x.xyz + ls.y * face.y.xyz + ls.z * face.z.xyz;
    vec4 clip = frame.clip_from_eye * vec4(from_eye, 1.0);
    return vec4(clip.xy, 0.5 * clip.w, clip.w);
}
