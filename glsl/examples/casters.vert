#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_ARB_shader_viewport_layer_array : require
#define UMBRAGE_CASTER_SET 0
#include "host/umbrage_caster.glsl"
#include "examples/sway.glsl"

// Casters that the host draws itself, bent by the wind.
layout(push_constant) uniform Push { float wind; };
layout(location = 0) in vec3 position;

void main() {
    int draw = gl_InstanceIndex;
    gl_Position = umbrage_caster_position(draw, umbrage_caster_vector(draw, sway(position, wind)));
    gl_Layer = umbrage_caster_layer(draw);
}
