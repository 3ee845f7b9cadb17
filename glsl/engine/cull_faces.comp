#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/key.glsl"

// Lists the faces that casters are tested against: those with pages, or those of which pages are drawn.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint FACE_CAPACITY = 6u;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(std430, binding = 1) buffer CountersBlock { Counters counters; };
layout(std430, binding = 2) readonly buffer Nodes { Node nodes[]; };
layout(std430, binding = 3) readonly buffer Roots { uint roots[]; };
layout(std430, binding = 4) writeonly buffer ActiveFaces { uint active_faces[]; };
layout(push_constant) uniform Push { uint list; };  // 0: faces with pages, 1: with pages to draw

void main() {
    uint face = gl_GlobalInvocationID.x;
    if (face >= min(frame.lights.x * FACES, FACE_CAPACITY) || roots[face] == 0u) {
        return;
    }
    if (list == 0u || (nodes[roots[face] - 1u].marks & (MARK_DRAWN | MARK_DRAWN << 1)) != 0u) {
        active_faces[list * FACE_CAPACITY + atomicAdd(counters.active_faces[list], 1u)] = face;
    }
}
