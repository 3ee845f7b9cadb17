// The lights that reach a tile of 8x8 receivers: box against range and cone. Needs `frame`, `lights` and 64 threads.

// Most lights: as many as keys can tell apart.
const uint MAX_LIGHTS = 1365u;

shared uint box_lights[(MAX_LIGHTS + 31u) / 32u];  // a bit for each light
shared uint box_near;
shared uint box_far;

uint light_words(Frame frame) { return (frame.lights.x + 31u) / 32u; }

// Whether a light with a place could reach anything in a box relative to the eye.
bool light_meets_box(Light light, vec3 low, vec3 high) {
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

// Fills `box_lights`; the caller puts a barrier before reading it. `depth`: of the receiver, above 0; not used without one.
void find_tile_lights(float depth, bool any_surface) {
    uint local = gl_LocalInvocationIndex;
    uint words = light_words(frame);
    for (uint i = local; i < words; i += 64u) {
        box_lights[i] = 0u;
    }
    if (local == 0u) {
        box_near = 0x7f800000u;
        box_far = 0u;
    }
    barrier();
    // without places the box does not matter; the bits of positive floats are ordered as they are
    if (frame.lights.y != 0u && any_surface) {
        atomicMin(box_near, floatBitsToUint(depth));
        atomicMax(box_far, floatBitsToUint(depth));
    }
    barrier();
    vec3 low = vec3(1e30);
    vec3 high = vec3(-1e30);
    for (uint i = 0u; i < 4u; i++) {
        vec2 corner = vec2(8u * (gl_WorkGroupID.xy + uvec2(i & 1u, i >> 1)));
        vec3 ray = frame.ray_corner.xyz + corner.x * frame.ray_dx.xyz + corner.y * frame.ray_dy.xyz;
        vec3 near = ray * uintBitsToFloat(box_near);
        vec3 far = ray * uintBitsToFloat(box_far);
        low = min(low, min(near, far));
        high = max(high, max(near, far));
    }
    for (uint i = local; i < frame.lights.x; i += 64u) {
        Light light = lights[frame.size.w + i];
        // a tile without receivers is met by no light with a place
        bool placed = light.kind.x > LIGHT_DIRECTIONAL && box_far != 0u && light_meets_box(light, low, high);
        if (placed || light.kind.x == LIGHT_DIRECTIONAL) {
            atomicOr(box_lights[i >> 5], 1u << (i & 31u));
        }
    }
}
