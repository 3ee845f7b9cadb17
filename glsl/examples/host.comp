#version 460

// The host's own pass after Umbrage: what the sun does not reach keeps a third of its colour.
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D color_image;
layout(binding = 1) uniform usampler2DArray mask;  // one light, 32 bits: floats
layout(std430, binding = 2) writeonly buffer Pixels { uint pixels[]; };

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = textureSize(color_image, 0);
    if (any(greaterThanEqual(pixel, size))) {
        return;
    }
    float visibility = uintBitsToFloat(texelFetch(mask, ivec3(pixel, 0), 0).r);
    vec3 color = texelFetch(color_image, pixel, 0).rgb * mix(0.33, 1.0, visibility);
    pixels[pixel.y * size.x + pixel.x] = packUnorm4x8(vec4(color, visibility));
}
