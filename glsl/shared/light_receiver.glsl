// Where receivers lie in the faces of lights. Needs light.glsl and SUN, a constant: whether the only light is a directional
// one in slot 0, so that everything else can be left out.

// The face that sees a direction, in light axes.
uint cube_face(vec3 v) {
    vec3 a = abs(v);
    if (a.z >= a.x && a.z >= a.y) {
        return v.z >= 0.0 ? 0u : 1u;
    }
    if (a.x >= a.y) {
        return v.x >= 0.0 ? 2u : 3u;
    }
    return v.y >= 0.0 ? 4u : 5u;
}

// A receiver as a light sees it.
struct Receiver {
    uint face;     // of the light
    ivec2 page;    // level-0 page
    vec2 inside;   // place in it, 0 to 1
    int level;     // finest level it may ask for
    float coarser; // weight of the next coarser level where levels are blended
    float depth;   // as stored: 1 nearest to the light, 0 farthest
    vec2 slope;    // change of stored depth per unit along the receiver's plane
    float per_length;  // stored depth per world length along z
    float unit;    // world length of a unit there
    vec2 dx;       // change of place per pixel, in units
    vec2 dy;
};

// Levels are blended over this share of each, at its coarse end.
const float BLEND_BAND = 0.5;

// The exponent of a squared length is read from its bits, so that the result is exact and equal on every device.
// RMSM (Lefohn et al. 2007, sec. 4): level = log2(sqrt(|dx x dy|)); min_length: log2(min(|dx|, |dy|)).
// `coarser` grows from 0 to 1 towards the next level, linearly in the parts of an octave of the squared length.
int footprint_level(Frame frame, Light light, vec2 dx, vec2 dy, out float coarser) {
    precise float squared;
    if (frame.size.z == 0u) {
        squared = abs(dx.x * dy.y - dx.y * dy.x);
    } else {
        precise float x = dx.x * dx.x + dx.y * dx.y;
        precise float y = dy.x * dy.x + dy.y * dy.y;
        squared = min(x, y);
    }
    precise float scaled = squared * light.rule.x;
    uint bits = floatBitsToUint(scaled);
    int exponent = int((bits >> 23) & 255u) - 127;
    int level = clamp(exponent >> 1, int(light.kind.w), ROOT_LEVEL);
    // between this level and the next: the lowest bit of the exponent and the fraction after it
    float between = float((bits + 0x00800000u) & 0xffffffu) * (1.0 / 16777216.0);
    coarser = level == exponent >> 1 && level < ROOT_LEVEL ? max((between - 1.0 + BLEND_BAND) / BLEND_BAND, 0.0) : 0.0;
    return level;
}

// What request and lookup both need of a receiver: whether the light reaches its front, and where it lies.
// `from_eye`: position relative to the eye, `n`: normal towards the eye, `dx`, `dy`: derivatives per pixel. World space.
bool light_receiver(Frame frame, Light light, vec3 from_eye, vec3 n, vec3 dx, vec3 dy, out Receiver r) {
    precise vec3 axis_dx = light_axes(light, dx);
    precise vec3 axis_dy = light_axes(light, dy);
    vec3 normal = light_axes(light, n);
    precise vec2 units;
    precise vec2 ls_dx = axis_dx.xy;
    precise vec2 ls_dy = axis_dy.xy;
    r.face = 0u;
    if (SUN || light.kind.x == LIGHT_DIRECTIONAL) {
        if (normal.z >= 0.0) {
            return false;
        }
        precise vec3 at = light_axes(light, from_eye);
        units = vec2(light.axis_x.w, light.axis_y.w) + at.xy * light.scale.x;
        r.page = light.eye_page.xy;
        r.depth = (light.axis_z.w - at.z) * light.scale.z;
        r.slope = normal.xy / normal.z * light.scale.y * light.scale.z;
        r.per_length = light.scale.z;
        r.unit = light.scale.y;
    } else {
        precise vec3 q = from_eye + light.eye.xyz;
        float facing = dot(n, q);
        float square = dot(q, q);
        precise vec3 at = light_axes(light, q);
        if (light.kind.x == LIGHT_NONE || facing >= 0.0 || square > light.place.w * light.place.w || at.z < light.eye.w * sqrt(square)) {
            return false;
        }
        if (light.kind.x == LIGHT_CUBE) {
            r.face = cube_face(at);
            at = face_axes(r.face, at);
            axis_dx = face_axes(r.face, axis_dx);
            axis_dy = face_axes(r.face, axis_dy);
            normal = face_axes(r.face, normal);
        }
        precise float inverse = 1.0 / at.z;
        precise vec2 projected = clamp(at.xy * inverse, -1.0, 1.0);
        units = projected * light.scale.x;
        r.page = ivec2(HALF);
        ls_dx = (axis_dx.xy - projected * axis_dx.z) * inverse;
        ls_dy = (axis_dy.xy - projected * axis_dy.z) * inverse;
        // on the plane n.q = c, 1 / z is linear in the projected position
        r.depth = light.scale.z * inverse;
        r.slope = light.scale.z * light.scale.y * light.axis_x.w * normal.xy / facing;
        r.per_length = r.depth * inverse;
        r.unit = light.scale.y * sqrt(light.axis_x.w) * at.z;
    }
    vec2 whole = floor(units);
    r.page += ivec2(whole);
    r.inside = units - whole;
    if (!SUN && light.kind.x != LIGHT_DIRECTIONAL) {
        // the far side of the last page
        ivec2 last = ivec2(2 * HALF - 1);
        r.inside = mix(r.inside, vec2(1.0), greaterThan(r.page, last));
        r.page = min(r.page, last);
    }
    r.dx = light.scale.x * ls_dx;
    r.dy = light.scale.x * ls_dy;
    r.level = footprint_level(frame, light, ls_dx, ls_dy, r.coarser);
    return true;
}

bool on_face(ivec2 page) { return all(greaterThanEqual(page, ivec2(0))) && all(lessThan(page, ivec2(2 * HALF))); }
