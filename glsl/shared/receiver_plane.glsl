// Writes what later passes need of a pixel: its depth along the view direction, 0 where there is no surface, and its plane.
// Needs `frame` and receiver.glsl; the includer declares binding 1, the depth image.
layout(binding = 2, rgba32ui) writeonly uniform uimage2D receiver_image;
layout(binding = 3, r32f) writeonly uniform image2D depth_out;

void store_plane(uvec2 pixel, float depth, uint word) {
    vec3 n = decode_normal(word);
    vec3 ray = pixel_ray(frame, pixel);
    // the plane is hit at depth z = c / (n.r(x)); its derivative follows from the quotient rule, here divided by z
    float along = dot(n, ray);
    along = min(along, -1e-6 * length(ray));
    float inv = 1.0 / (along * frame.ray_dy.w);
    vec3 dx = (frame.ray_dx.xyz * along - ray * dot(n, frame.ray_dx.xyz)) * inv;
    vec3 dy = (frame.ray_dy.xyz * along - ray * dot(n, frame.ray_dy.xyz)) * inv;
    dx = clamp(dx, -65000.0, 65000.0);
    dy = clamp(dy, -65000.0, 65000.0);
    uvec4 receiver = uvec4(word, packHalf2x16(dx.xy), packHalf2x16(vec2(dx.z, dy.x)), packHalf2x16(dy.yz));
    imageStore(receiver_image, ivec2(pixel), receiver);
    imageStore(depth_out, ivec2(pixel), vec4(depth));
}

void store_nothing(uvec2 pixel) {
    imageStore(receiver_image, ivec2(pixel), uvec4(0u));
    imageStore(depth_out, ivec2(pixel), vec4(0.0));
}
