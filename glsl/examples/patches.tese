#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_ARB_shader_viewport_layer_array : require
#define UMBRAGE_CASTER_SET 0
#include "host/umbrage_caster.glsl"
#include "examples/sway.glsl"

layout(triangles, equal_spacing, ccw) in;
layout(push_constant) uniform Push { float wind; };
layout(location = 0) in vec3 patch_corner[];
layout(location = 1) patch in int draw;

void main() {
    vec3 position = gl_TessCoord.x * patch_corner[0] + gl_TessCoord.y * patch_corner[1] + gl_TessCoord.z * patch_corner[2];
    gl_Position = umbrage_caster_position(draw, umbrage_caster_vector(draw, sway(position, wind)));
    gl_Layer = umbrage_caster_layer(draw);
}
