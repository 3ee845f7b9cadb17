#version 460

// Lays text over the picture.
layout(local_size_x = 8, local_size_y = 8) in;
layout(std430, binding = 0) readonly buffer Text { uint text[]; };  // RGBA8, as wide as the picture
layout(binding = 1, rgba8) uniform image2D target_image;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(target_image);
    if (any(greaterThanEqual(pixel, size))) {
        return;
    }
    vec4 over = unpackUnorm4x8(text[pixel.y * size.x + pixel.x]);
    if (over.a > 0.0) {
        imageStore(target_image, pixel, vec4(mix(imageLoad(target_image, pixel).rgb, over.rgb, over.a), 1.0));
    }
}
