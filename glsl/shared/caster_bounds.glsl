// Bounds of casters as the faces of lights see them. Needs light.glsl, `lights` (Light array), `frame`, PAGE_TEXELS and
// GUTTER. Everything is `precise`: passes that must agree on which page a caster touches give the same bits whatever the
// compiler makes of each.

// A box: its middle, relative to the scene's origin, and its three half axes, world space.
struct Box {
    vec3 center;
    vec3 half_axes[3];
};

Box box_of(Instance instance, vec3 middle, vec3 extent) {
    vec4 center = vec4(middle, 1.0);
    Box box;
    box.center = vec3(dot(instance.rows[0], center), dot(instance.rows[1], center), dot(instance.rows[2], center));
    for (int i = 0; i < 3; i++) {
        box.half_axes[i] = vec3(instance.rows[0][i], instance.rows[1][i], instance.rows[2][i]) * extent[i];
    }
    return box;
}

Box cluster_box(Instance instance, Cluster cluster) {
    vec3 center = vec3(cluster.center[0], cluster.center[1], cluster.center[2]);
    return box_of(instance, center, vec3(cluster.extent[0], cluster.extent[1], cluster.extent[2]));
}

Box mesh_box(Instance instance, MeshBounds mesh) {
    vec3 center = vec3(mesh.center[0], mesh.center[1], mesh.center[2]);
    return box_of(instance, center, vec3(mesh.extent[0], mesh.extent[1], mesh.extent[2]));
}

// Half the size of the axis-aligned box around a box.
vec3 box_reach(Box box) {
    precise vec3 reach = abs(box.half_axes[0]) + abs(box.half_axes[1]) + abs(box.half_axes[2]);
    return reach;
}

// Whether a light with a place could see anything of a box.
bool light_meets(Light light, Box box) {
    vec3 beyond = max(abs(box.center - light.place.xyz) - box_reach(box), vec3(0.0));
    return dot(beyond, beyond) <= light.place.w * light.place.w * 1.0001;
}

// Units by which rounding may move projected bounds.
const float ROUNDING = 5.12;

// Bounds of a box in level-0 pages from the face's lower corner, widened by rounding; false where the face sees nothing
// of it.
bool face_bounds(Light light, uint f, Box box, out precise vec2 low, out precise vec2 high) {
    if (light.kind.x == LIGHT_DIRECTIONAL) {
        precise vec2 c = vec2(dot(light.axis_x.xyz, box.center), dot(light.axis_y.xyz, box.center));
        precise vec2 e = vec2(0.0);
        for (int i = 0; i < 3; i++) {
            e += abs(vec2(dot(light.axis_x.xyz, box.half_axes[i]), dot(light.axis_y.xyz, box.half_axes[i])));
        }
        low = (c - e) * light.scale.x + (float(HALF) - ROUNDING);
        high = (c + e) * light.scale.x + (float(HALF) + ROUNDING);
        return true;
    }
    if (!light_meets(light, box)) {
        return false;
    }
    precise vec3 c = face_axes(f, light_axes(light, box.center - light.place.xyz));
    precise vec3 h[3];
    precise vec3 reach = vec3(0.0);
    // the four sides of the face's pyramid, widened by the gutter of the root page
    float side = 1.0 + 2.0 * float(GUTTER + 1u) / frame.rule.x;
    precise vec4 beside = vec4(0.0);
    for (int i = 0; i < 3; i++) {
        h[i] = face_axes(f, light_axes(light, box.half_axes[i]));
        reach += abs(h[i]);
        beside += abs(vec4(side * h[i].z - h[i].x, side * h[i].z + h[i].x, side * h[i].z - h[i].y, side * h[i].z + h[i].y));
    }
    precise vec4 inside = vec4(side * c.z - c.x, side * c.z + c.x, side * c.z - c.y, side * c.z + c.y) + beside;
    float slack = 1e-5 * (length(c) + length(reach));
    if (any(lessThan(inside, vec4(-slack))) || c.z + reach.z < light.scale.z - slack) {
        return false;
    }
    low = vec2(0.0);
    high = vec2(float(2 * HALF));
    if (c.z - reach.z <= light.scale.z + slack) {
        // it comes too close to the light's plane to be projected
        low -= vec2(float(HALF));
        high += vec2(float(HALF));
        return true;
    }
    precise vec2 least = vec2(1e30);
    precise vec2 most = vec2(-1e30);
    for (uint i = 0u; i < 8u; i++) {
        precise vec3 corner = c + ((i & 1u) != 0u ? h[0] : -h[0]) + ((i & 2u) != 0u ? h[1] : -h[1]) + ((i & 4u) != 0u ? h[2] : -h[2]);
        precise vec2 at = corner.xy / corner.z;
        least = min(least, at);
        most = max(most, at);
    }
    low = least * light.scale.x + (float(HALF) - ROUNDING);
    high = most * light.scale.x + (float(HALF) + ROUNDING);
    return true;
}

// Rounding of projected coordinates reaches a quarter of a texel at level 9; the rasteriser snaps to 1/256.
float texel_margin(int level) { return 1.0 / 64.0 + 0.25 * power_of_two(9 - level); }

// Whether bounds in texels of a page cover no texel centre of the page.
bool misses(vec2 low, vec2 high, float margin) {
    precise vec2 first = max(ceil(low - 0.5 - margin), vec2(0.0));
    precise vec2 last = min(floor(high - 0.5 + margin), vec2(float(PAGE_TEXELS - 1u)));
    return any(greaterThan(first, last));
}

// Whether bounds in level-0 pages cover no texel centre of a page.
bool page_missed(uvec2 key, vec2 low, vec2 high) {
    int level = key_level(key);
    float side = power_of_two(level);
    vec2 corner = vec2(key_page(key)) * side;
    precise float texels = frame.rule.x / side;
    precise vec2 from = (low - corner) * texels + float(GUTTER);
    precise vec2 to = (high - corner) * texels + float(GUTTER);
    return misses(from, to, texel_margin(level));
}
