// The lights that reach a tile of 8x8 receivers: box against range and cone. Needs `frame`, `lights` and 64 threads.

// Most lights: as many as keys can tell apart.
const uint MAX_LIGHTS = 1365u;

shared uint box_lights[(MAX_LIGHTS + 31u) / 32u];  // a bit for each light
shared uint box_low[3];
shared uint box_high[3];

uint light_words(Frame frame) { return (frame.lights.x + 31u) / 32u; }

// Unsigned integers in the order of the floats.
uint ordered(float v) {
    uint bits = floatBitsToUint(v);
    return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}
float unordered(uint bits) { return uintBitsToFloat((bits & 0x80000000u) != 0u ? bits & 0x7fffffffu : ~bits); }

// Whether light could fall anywhere into a box relative to the eye.
bool light_meets_box(Light light, vec3 low, vec3 high) {
    if (light.kind.x <= LIGHT_DIRECTIONAL) {
        return light.kind.x == LIGHT_DIRECTIONAL;
    }
    vec3 center = 0.5 * (low + high) + light.eye.xyz;
    vec3 reach = 0.5 * (high - low);
    vec3 beyond = max(abs(center) - reach, vec3(0.0));
    if (dot(beyond, beyond) > light.place.w * light.place.w) {
        return false;
    }
    if (light.eye.w <= -1.0) {
        return true;
    }
    // the cone against the sphere around the box
    float radius = length(reach) * 1.0001;
    float along = dot(light.axis_z.xyz, center);
    float across = sqrt(max(dot(center, center) - along * along, 0.0));
    float sine = sqrt(max(1.0 - light.eye.w * light.eye.w, 0.0));
    return across * light.eye.w - along * sine <= radius + 1e-5 * length(center);
}

// Fills `box_lights`; the caller puts a barrier before reading it.
void find_tile_lights(vec3 from_eye, bool any_surface) {
    uint local = gl_LocalInvocationIndex;
    uint words = light_words(frame);
    for (uint i = local; i < words; i += 64u) {
        box_lights[i] = 0u;
    }
    if (local < 3u) {
        box_low[local] = 0xffffffffu;
        box_high[local] = 0u;
    }
    barrier();
    // without places the box does not matter
    if (frame.lights.y != 0u && any_surface) {
        for (int i = 0; i < 3; i++) {
            atomicMin(box_low[i], ordered(from_eye[i]));
            atomicMax(box_high[i], ordered(from_eye[i]));
        }
    }
    barrier();
    vec3 low = vec3(unordered(box_low[0]), unordered(box_low[1]), unordered(box_low[2]));
    vec3 high = vec3(unordered(box_high[0]), unordered(box_high[1]), unordered(box_high[2]));
    for (uint i = local; i < frame.lights.x; i += 64u) {
        if (light_meets_box(lights[frame.size.w + i], low, high)) {
            atomicOr(box_lights[i >> 5], 1u << (i & 31u));
        }
    }
}
