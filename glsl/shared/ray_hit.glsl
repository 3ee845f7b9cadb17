// Points where rays meet casters. The includer defines RAY_BINDING, after which come five bindings, and RAY_CONSTANT, the first
// of three constants, and includes shared/structs.glsl and shared/split.glsl.
layout(constant_id = RAY_CONSTANT) const uint POSITION_STRIDE = 3u;
layout(constant_id = RAY_CONSTANT + 1) const uint POSITION_OFFSET = 0u;
layout(constant_id = RAY_CONSTANT + 2) const uint POSITION_FORMAT = 0u;
layout(std430, binding = RAY_BINDING + 1) readonly buffer Instances { Instance instances[]; };
layout(std430, binding = RAY_BINDING + 2) readonly buffer Positions { uint positions[]; };
layout(std430, binding = RAY_BINDING + 3) readonly buffer Attributes { uint attributes[]; };
layout(std430, binding = RAY_BINDING + 4) readonly buffer Materials { Material materials[]; };
layout(std430, binding = RAY_BINDING + 5) readonly buffer Texels { uint texels[]; };

#include "shared/alpha.glsl"

// Share of the ray on both sides of its origin in which a surface is looked for, beyond the rounding of what meets triangles.
const float SEARCH = 0.1;

// How far a receiver may lie off its surface, in its distances from the eye: twice what was seen at 2 cm from a triangle of
// 10 km.
const float SNAP = 5e-3;

#include "shared/position.glsl"

// A point of a triangle: its vertices and their weights.
struct Met {
    uint triangle;
    uvec3 vertices;
    vec3 weights;
};

// Alpha of a point.
float alpha_of(Material material, Met met) {
    vec2 uv = vec2(0.0);
    float alpha = 0.0;
    for (int i = 0; i < 3; i++) {
        uint at = 3u * met.vertices[i];
        uv += met.weights[i] * uintBitsToFloat(uvec2(attributes[at], attributes[at + 1u]));
        alpha += met.weights[i] * float(attributes[at + 2u] >> 24);
    }
    return base_color(material, uv, vec4(1.0, 1.0, 1.0, alpha / 255.0)).a;
}

// Whether a point is not cut away.
bool solid(uint instance, Met met) {
    Material material = materials[instances[instance].material];
    return alpha_of(material, met) >= material.alpha_cutoff;
}

// A triangle that a ray lies on: instance, triangle of the scene, and how far before or after the ray's origin.
struct Surface {
    uint instance;
    uint triangle;
    float t;
};

const uint NO_TRIANGLE = 0xffffffffu;

// Where a ray meets the plane of a triangle: by the plane's distance, which holds where the triangle is so large that the
// weights of its corners do not.
float plane_t(Instance instance, Met met, vec3 origin, vec3 direction) {
    vec3 p = position(met.vertices.x);
    vec3 a = linear(instance, position(met.vertices.y) - p), b = linear(instance, position(met.vertices.z) - p);
    precise vec3 n = cross(a, b);
    precise vec3 from = eye_to_instance(frame, instance) - origin + linear(instance, p);
    precise float above = dot(n, from);
    return above / dot(n, direction);
}
