#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/frame.glsl"
#include "shared/structs.glsl"
#include "shared/split.glsl"

// The casters as VkAccelerationStructureInstanceKHR, four words of four each, relative to the eye. One thread an instance.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint INSTANCE_COUNT = 1u;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(std430, binding = 1) readonly buffer Instances { Instance instances[]; };
layout(std430, binding = 2) readonly buffer Shapes { uvec2 shapes[]; };  // address of the structure of each mesh
layout(std430, binding = 3) writeonly buffer Records { uvec4 records[]; };

const uint FORCE_OPAQUE = 4u;  // VkGeometryInstanceFlagBitsKHR
const uint FORCE_NO_OPAQUE = 8u;

// Traversal inverts the matrix. Instances squashed flat get this share of their size as thickness.
const float THICKNESS = 1e-4;

vec3 longest(vec3 a, vec3 b, vec3 c) {
    vec3 ab = dot(a, a) >= dot(b, b) ? a : b;
    return dot(ab, ab) >= dot(c, c) ? ab : c;
}

// A matrix with an inverse, from the rows of one that may have none; false for one that leaves no more than a line.
bool invertible(inout mat3 rows) {
    mat3 adjugate = mat3(cross(rows[1], rows[2]), cross(rows[2], rows[0]), cross(rows[0], rows[1]));
    float condition = length(rows[0]) * length(adjugate[0]) + length(rows[1]) * length(adjugate[1]) + length(rows[2]) * length(adjugate[2]);
    if (abs(dot(rows[0], adjugate[0])) > 1e-6 * condition) {
        return true;
    }
    mat3 columns = transpose(rows);
    vec3 lost = longest(adjugate[0], adjugate[1], adjugate[2]);  // direction in mesh space
    vec3 normal = longest(cross(columns[1], columns[2]), cross(columns[2], columns[0]), cross(columns[0], columns[1]));
    if (!(dot(lost, lost) > 0.0 && dot(normal, normal) > 0.0)) {
        return false;
    }
    float thickness = THICKNESS * length(longest(rows[0], rows[1], rows[2]));
    rows += thickness * outerProduct(normalize(lost), normalize(normal));
    return true;
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= INSTANCE_COUNT) {
        return;
    }
    Instance instance = instances[index];
    mat3 rows = mat3(instance.rows[0].xyz, instance.rows[1].xyz, instance.rows[2].xyz);
    vec3 offset = eye_to_instance(frame, instance);
    vec3 size = abs(rows[0]) + abs(rows[1]) + abs(rows[2]) + abs(offset);
    bool finite = size.x + size.y + size.z < 3e38;
    bool casts = (instance.flags & 3u) != POLICY_NEVER && finite && invertible(rows);
    uint flags = (instance.flags & ALPHA_TESTED) != 0u ? FORCE_NO_OPAQUE : FORCE_OPAQUE;
    records[4u * index] = floatBitsToUint(vec4(rows[0], offset.x));
    records[4u * index + 1u] = floatBitsToUint(vec4(rows[1], offset.y));
    records[4u * index + 2u] = floatBitsToUint(vec4(rows[2], offset.z));
    // without a structure an instance is inactive
    records[4u * index + 3u] = uvec4(index & 0xffffffu | 0xffu << 24, flags << 24, casts ? shapes[instance.mesh] : uvec2(0u));
}
