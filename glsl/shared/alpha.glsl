// Base colour and alpha at a texture coordinate: bilinear at the base level. Mirrors src/truth/alpha.rs.
// Needs `materials` and `texels`.

uint wrap_texel(int i, uint n, uint mode) {
    int size = int(n);
    if (mode == 2u) {
        return uint(clamp(i, 0, size - 1));
    }
    if (mode == 1u) {
        int period = 2 * size;
        int m = i - period * int(floor(float(i) / float(period)));
        m = clamp(m, 0, period - 1);
        return uint(m < size ? m : period - 1 - m);
    }
    int m = i - size * int(floor(float(i) / float(size)));
    return uint(clamp(m, 0, size - 1));
}

vec4 texel_at(Material material, int x, int y) {
    uint tx = wrap_texel(x, material.width, material.wrap & 3u);
    uint ty = wrap_texel(y, material.height, (material.wrap >> 2) & 3u);
    return unpackUnorm4x8(texels[material.texel_offset + ty * material.width + tx]);
}

vec4 base_color(Material material, vec2 uv, vec4 vertex_color) {
    vec4 color = material.base_color * vertex_color;
    if (material.texel_offset == 0xffffffffu) {
        return color;
    }
    vec2 st = vec2(dot(material.uv_row0.xyz, vec3(uv, 1.0)), dot(material.uv_row1.xyz, vec3(uv, 1.0)));
    vec2 position = st * vec2(material.width, material.height) - 0.5;
    vec2 low = floor(position);
    vec2 f = position - low;
    ivec2 i = ivec2(low);
    vec4 top = mix(texel_at(material, i.x, i.y), texel_at(material, i.x + 1, i.y), f.x);
    vec4 bottom = mix(texel_at(material, i.x, i.y + 1), texel_at(material, i.x + 1, i.y + 1), f.x);
    vec4 texel = mix(top, bottom, f.y);
    return color * vec4(pow(texel.rgb, vec3(2.2)), texel.a);
}
