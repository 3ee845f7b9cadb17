// Where a point of a caster lies in a page: texels relative to the page's own corner, so that a page's content depends on its
// address and its casters only. Needs structs.glsl, key.glsl and light.glsl. `from_anchor`: from the zero of the instance's
// mesh space, world axes, world units. Clip space.
vec4 place_in_page(Light light, Page page, Pair pair, vec3 from_anchor, float page_texels, float gutter) {
    vec3 ls = vec3(pair.anchor[0], pair.anchor[1], pair.anchor[2]) + light_axes(light, from_anchor);
    float w = 1.0;
    float depth = -ls.z * light.scale.z;
    if (light.kind.x != LIGHT_DIRECTIONAL) {
        ls = face_axes(key_face(page.key) % FACES, ls);
        w = ls.z;
        ls.xy -= page.origin * w;
        depth = light.scale.z;
    }
    vec2 texel = ls.xy * page.scale + gutter * w;
    return vec4(texel * (2.0 / page_texels) - w, depth, w);
}

// The layer of the atlas that a pair is drawn into.
int pair_layer(Page page, Pair pair) { return int((pair.target & 1u) == 0u ? page.slot : page.dynamic_slot); }
