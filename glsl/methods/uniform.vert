#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "methods/fit.glsl"
#include "methods/uniform_vertex.glsl"

void main() {
    Instance instance;
    place_vertex(instance);
}
