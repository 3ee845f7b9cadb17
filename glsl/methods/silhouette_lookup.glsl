// Which corner of a texel of the silhouette map decides (Sen, Cammarano, Hanrahan 2003, 3.2). Needs `silhouette_map`.
vec2 silhouette_point(uint layer, ivec2 texel) { return texelFetch(silhouette_map, ivec3(texel, layer), 0).xy; }

float turn(vec2 a, vec2 b) { return a.x * b.y - a.y * b.x; }

bool between(vec2 first, vec2 p, vec2 second) { return turn(first, p) >= 0.0 && turn(p, second) >= 0.0; }

// The texel's point and those of its four neighbours divide it into four skewed quadrants, one for each corner. They may open
// more than half a turn, so each is tested as two sectors, on both sides of its corner. `p`: in the texel; returns 0 or 1 for x
// and y of the corner.
ivec2 corner_of(uint layer, ivec2 texel, vec2 p) {
    const ivec2 SIDES[4] = ivec2[](ivec2(1, 0), ivec2(0, 1), ivec2(-1, 0), ivec2(0, -1));
    vec2 middle = silhouette_point(layer, texel);
    vec2 rays[4];
    for (int i = 0; i < 4; i++) {
        rays[i] = vec2(SIDES[i]) + silhouette_point(layer, texel + SIDES[i]) - middle;
    }
    p -= middle;
    ivec2 chosen = ivec2(1);
    for (int i = 0; i < 4; i++) {
        int next = (i + 1) & 3;
        ivec2 corner = (SIDES[i] + SIDES[next] + 1) / 2;
        vec2 diagonal = vec2(corner) - middle;
        if (between(rays[i], p, diagonal) || between(diagonal, p, rays[next])) {
            chosen = corner;
        }
    }
    return chosen;
}
