#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_ARB_shader_viewport_layer_array : require
#include "shared/structs.glsl"
#include "methods/fit.glsl"
#define LIGHT_BINDING 0
#include "methods/light.glsl"
layout(constant_id = 0) const uint LAYER = 0u;
layout(std430, binding = 1) readonly buffer Fits { Fit fits[]; };
layout(binding = 2) uniform sampler2DArray map;
#define SILHOUETTE_BINDING 3
#define LIST_ACCESS readonly
#include "methods/silhouette.glsl"

// A rectangle around a silhouette edge that holds the centre of every texel that the edge passes (source, 3.1).
layout(location = 0) flat out vec3 from;  // xy: texels of the silhouette map, z: stored depth
layout(location = 1) flat out vec3 to;
layout(location = 2) flat out uint number;

// Half a texel's diagonal, and room for the larger texel of the fragment shader.
const float WIDTH = 0.75;
// Texels around the map in which ends of edges are kept.
const float ROOM = 4.0;

// In clip space, but for x and y, which are 0 to w.
vec4 placed(Instance instance, uint vertex) {
    vec3 world = world_position(instance, vertex);
    uint face = face_of(LAYER);
    vec3 ls = light_space(face, world - light.eye.xyz);
    ls.z = dot(light.faces[face].z.xyz, world) + light.faces[face].origin.x;
    vec3 t = vec3(ls.xy, divisor(ls.z));
    Fit fit = fits[LAYER];
    vec2 uv = vec2(dot(fit.row_u.xyz, t), dot(fit.row_v.xyz, t));
    return vec4(uv, light.depth.x * ls.z + light.depth.y, dot(fit.row_w.xyz, t));
}

// Keeps of the range of a parameter that begins with value `at` and changes by `change` what is not negative.
void clip(inout vec2 range, float at, float change) {
    if (change > 0.0) {
        range.x = max(range.x, -at / change);
    } else if (change < 0.0) {
        range.y = min(range.y, at / -change);
    } else if (at < 0.0) {
        range.y = -1.0;
    }
}

void main() {
    gl_Layer = int(LAYER);
    number = silhouettes[gl_VertexIndex / 6];
    EdgeRun run = runs[number / RUN_EDGES];
    Edge edge = edges[run.first + number % RUN_EDGES];
    Instance instance = instances[run.instance];
    vec4 a = placed(instance, edge.ends[0]);
    vec4 b = placed(instance, edge.ends[1]);
    // what lies before the near plane
    vec2 range = vec2(0.0, 1.0);
    clip(range, a.w - a.z, (b.w - b.z) - (a.w - a.z));
    gl_Position = vec4(0.0, 0.0, 0.0, 1.0);  // all six: no triangle
    if (range.y < range.x) {
        return;
    }
    vec4 near = mix(a, b, range.x), far = mix(a, b, range.y);
    float side = float(textureSize(map, 0).x);
    // the silhouette map lies half a texel beside the depth map: its texels' corners are centres of texels there
    from = vec3(near.xy / near.w * side - 0.5, near.z / near.w);
    to = vec3(far.xy / far.w * side - 0.5, far.z / far.w);
    // long edges lose what lies outside, so that the rest keeps its precision
    vec2 inside = vec2(0.0, 1.0);
    for (int i = 0; i < 2; i++) {
        clip(inside, from[i] + ROOM, to[i] - from[i]);
        clip(inside, side + ROOM - from[i], from[i] - to[i]);
    }
    if (inside.y < inside.x) {
        return;
    }
    vec3 whole = to - from;
    to = from + inside.y * whole;
    from += inside.x * whole;
    vec2 along = to.xy - from.xy;
    along = WIDTH * (length(along) > 1e-6 ? normalize(along) : vec2(1.0, 0.0));
    const uint CORNERS[6] = uint[](0u, 1u, 2u, 2u, 1u, 3u);
    uint corner = CORNERS[gl_VertexIndex % 6];
    vec2 p = (corner & 1u) == 0u ? from.xy - along : to.xy + along;
    p += (corner & 2u) == 0u ? vec2(-along.y, along.x) : vec2(along.y, -along.x);
    gl_Position = vec4(2.0 * p / side - 1.0, 0.0, 1.0);
}
