#version 460

// Least and greatest depth of each layer that was drawn. A workgroup a layer.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint PAGE_TEXELS = 128u;
layout(binding = 0) uniform sampler2DArray atlas;
layout(std430, binding = 1) readonly buffer Cleared { uint cleared[]; };
layout(std430, binding = 2) writeonly buffer Ranges { vec2 ranges[]; };

// depths are not negative, so that their bits are in their order
shared uint least;
shared uint greatest;

void main() {
    uint layer = cleared[gl_WorkGroupID.x];
    if (gl_LocalInvocationIndex == 0u) {
        least = floatBitsToUint(1.0);
        greatest = 0u;
    }
    barrier();
    vec2 range = vec2(1.0, 0.0);
    const uint quads = PAGE_TEXELS / 2u;
    for (uint i = gl_LocalInvocationIndex; i < quads * quads; i += 64u) {
        vec2 meet = (vec2(i % quads, i / quads) + 0.5) / float(quads);
        vec4 d = textureGather(atlas, vec3(meet, float(layer)), 0);
        range.x = min(range.x, min(min(d.x, d.y), min(d.z, d.w)));
        range.y = max(range.y, max(max(d.x, d.y), max(d.z, d.w)));
    }
    atomicMin(least, floatBitsToUint(range.x));
    atomicMax(greatest, floatBitsToUint(range.y));
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        ranges[layer] = vec2(uintBitsToFloat(least), uintBitsToFloat(greatest));
    }
}
