// Whether a ray meets a caster: a walk through the tree of glsl/shared/bvh.glsl. The includer defines RAY_BINDING, the first
// of six bindings, and includes shared/structs.glsl, shared/split.glsl and shared/receiver.glsl; constants 0 to 14 are taken.
// Space is relative to the eye of `frame`, so that nothing near it is rounded more than its distance asks for.
#include "shared/bvh.glsl"
layout(constant_id = 11) const uint CULL = 0u;  // sides of casters left out: 0 none, 1 back, 2 front
layout(constant_id = 12) const bool ALPHA = true;  // whether any caster is alpha tested
layout(std430, binding = RAY_BINDING) readonly buffer Tree { uvec4 tree[]; };

#define RAY_CONSTANT 13
#include "shared/ray_hit.glsl"

// A ray in the steps of a box test: a box is met between near * inverse + near_shift and far * inverse + far_shift.
struct BoxRay {
    vec3 inverse;
    vec3 near_shift;
    vec3 far_shift;
};

// Components too small to divide by grow to a share of the longest that no box can tell from 0.
vec3 divisible(vec3 d) {
    float least = 1e-12 * max(max(abs(d.x), abs(d.y)), abs(d.z));
    return mix(d, vec3(least), lessThan(abs(d), vec3(least)));
}

// Which of four boxes a ray meets in a range of t: a bit for each.
uint box_mask(BoxRay ray, vec2 range, vec4 near_x, vec4 near_y, vec4 near_z, vec4 far_x, vec4 far_y, vec4 far_z) {
    vec4 begin = max(near_x * ray.inverse.x + ray.near_shift.x, near_y * ray.inverse.y + ray.near_shift.y);
    begin = max(begin, max(near_z * ray.inverse.z + ray.near_shift.z, vec4(range.x)));
    vec4 end = min(far_x * ray.inverse.x + ray.far_shift.x, far_y * ray.inverse.y + ray.far_shift.y);
    end = min(end, min(far_z * ray.inverse.z + ray.far_shift.z, vec4(range.y)));
    uvec4 bits = mix(uvec4(0u), uvec4(1u, 2u, 4u, 8u), lessThanEqual(begin, end));
    return bits.x | bits.y | bits.z | bits.w;
}

uint top_mask(BoxRay ray, vec2 range, uint node) {
    uvec4 x = tree[3u * node], y = tree[3u * node + 1u], z = tree[3u * node + 2u];
    uvec3 near = mix(uvec3(0u), uvec3(16u), lessThan(ray.inverse, vec3(0.0)));
    uvec3 far = 16u - near;
    return box_mask(
        ray, range, vec4(x >> near.x & 0xffffu), vec4(y >> near.y & 0xffffu), vec4(z >> near.z & 0xffffu),
        vec4(x >> far.x & 0xffffu), vec4(y >> far.y & 0xffffu), vec4(z >> far.z & 0xffffu)
    );
}

uint cluster_mask(BoxRay ray, vec2 range, uint node) {
    uvec4 low = tree[node], high = tree[node + 1u];
    bvec3 turned = lessThan(ray.inverse, vec3(0.0));
    uvec4 near_x = turned.x ? high : low, far_x = turned.x ? low : high;
    uvec4 near_y = turned.y ? high : low, far_y = turned.y ? low : high;
    uvec4 near_z = turned.z ? high : low, far_z = turned.z ? low : high;
    return box_mask(
        ray, range, vec4(near_x & 1023u), vec4(near_y >> 10 & 1023u), vec4(near_z >> 20),
        vec4(far_x & 1023u), vec4(far_y >> 10 & 1023u), vec4(far_z >> 20)
    );
}

// Space sheared along a ray: x and y are 0 on it, z is its parameter (Woop, Benthin and Wald 2013). Rows to it from world
// space relative to the ray's origin, or from mesh space.
struct Shear {
    vec4 rows[3];
    bool turned;  // the rows mirror what the light sees
};

Shear shear_of(vec3 d) {
    vec3 a = abs(d);
    Shear shear;
    if (a.x >= a.y && a.x >= a.z) {
        shear.rows = vec4[3](vec4(-d.y / d.x, 1.0, 0.0, 0.0), vec4(-d.z / d.x, 0.0, 1.0, 0.0), vec4(1.0 / d.x, 0.0, 0.0, 0.0));
        shear.turned = d.x < 0.0;
    } else if (a.y >= a.z) {
        shear.rows = vec4[3](vec4(0.0, -d.z / d.y, 1.0, 0.0), vec4(1.0, -d.x / d.y, 0.0, 0.0), vec4(0.0, 1.0 / d.y, 0.0, 0.0));
        shear.turned = d.y < 0.0;
    } else {
        shear.rows = vec4[3](vec4(1.0, 0.0, -d.x / d.z, 0.0), vec4(0.0, 1.0, -d.y / d.z, 0.0), vec4(0.0, 0.0, 1.0 / d.z, 0.0));
        shear.turned = d.z < 0.0;
    }
    return shear;
}

// The same from the mesh space of an instance. What is far from zero, its place and the eye's, is subtracted first.
Shear placed(Shear shear, Instance instance, vec3 origin) {
    vec3 offset = eye_to_instance(frame, instance) - origin;
    for (int i = 0; i < 3; i++) {
        vec3 s = shear.rows[i].xyz;
        shear.rows[i] = vec4(s.x * instance.rows[0].xyz + s.y * instance.rows[1].xyz + s.z * instance.rows[2].xyz, dot(s, offset));
    }
    return shear;
}

vec3 sheared(Shear shear, uint vertex) {
    vec4 p = vec4(position(vertex), 1.0);
    precise vec3 at = vec3(dot(shear.rows[0], p), dot(shear.rows[1], p), dot(shear.rows[2], p));
    return at;
}

// Neighbours compute the same edge function with opposite signs, so no ray slips through a shared edge. A triangle seen
// edge-on is not met.
bool triangle_met(Shear shear, bool mirrored, vec2 range, uint triangle, out Met met) {
    met.triangle = triangle;
    met.vertices = tree[TRIANGLES + triangle].xyz;
    vec3 a = sheared(shear, met.vertices.x), b = sheared(shear, met.vertices.y), c = sheared(shear, met.vertices.z);
    precise float u = c.x * b.y - c.y * b.x;
    precise float v = a.x * c.y - a.y * c.x;
    precise float w = b.x * a.y - b.y * a.x;
    float determinant = u + v + w;
    bool inside = (min(min(u, v), w) >= 0.0 || max(max(u, v), w) <= 0.0) && determinant != 0.0;
    float t = (u * a.z + v * b.z + w * c.z) / determinant;
    bool front = ((determinant < 0.0) != shear.turned) != mirrored;
    met.weights = vec3(u, v, w) / determinant;
    return inside && t > range.x && t < range.y && (CULL == 0u || front == (CULL == 1u));
}

// Where a walk is: a node's level and its number there, two bits a level. The trail holds four bits a level for the
// children still to visit, the lowest for those of the last node. Only top nodes beyond seven levels need its second word.
struct Walk {
    uint level;
    uint path;
    uvec2 trail;
};

// Moves to the next child on the trail, which is not empty.
void next_child(inout Walk walk, const bool wide) {
    if (wide && walk.trail.x == 0u) {
        // the eight lowest levels have nothing left
        walk.trail = uvec2(walk.trail.y, 0u);
        walk.level -= 8u;
        walk.path >>= 16;
    }
    uint bit = uint(findLSB(walk.trail.x));
    uint up = bit >> 2;
    walk.trail.x >>= 4u * up;
    if (wide && up > 0u) {
        walk.trail.x |= walk.trail.y << (32u - 4u * up);
        walk.trail.y >>= 4u * up;
    }
    walk.trail.x &= walk.trail.x - 1u;
    walk.level += 1u - up;
    walk.path = walk.path >> (2u * up) << 2 | (bit & 3u);
}

void push_children(inout Walk walk, uint mask, const bool wide) {
    if (wide) {
        walk.trail.y = walk.trail.y << 4 | walk.trail.x >> 28;
    }
    walk.trail.x = walk.trail.x << 4 | mask;
}

Caster read_caster(uint index) {
    uint at = CASTERS + 4u * index;
    uvec4 ids = tree[at + 3u];
    vec4 rows[3] = vec4[3](uintBitsToFloat(tree[at]), uintBitsToFloat(tree[at + 1u]), uintBitsToFloat(tree[at + 2u]));
    return Caster(rows, ids.x, ids.y, ids.z, uintBitsToFloat(ids.w));
}

// The ray in the steps of a caster's boxes.
BoxRay caster_ray(Caster caster, vec3 origin, vec3 direction) {
    vec4 o = vec4(origin, 1.0);
    vec3 from = vec3(dot(caster.rows[0], o), dot(caster.rows[1], o), dot(caster.rows[2], o));
    vec3 d = vec3(dot(caster.rows[0].xyz, direction), dot(caster.rows[1].xyz, direction), dot(caster.rows[2].xyz, direction));
    BoxRay ray;
    // without a direction, in a flat instance, all boxes are met
    ray.inverse = d == vec3(0.0) ? vec3(0.0) : 1.0 / divisible(d);
    ray.near_shift = -from * ray.inverse - caster.margin * abs(ray.inverse);
    ray.far_shift = -from * ray.inverse + caster.margin * abs(ray.inverse);
    return ray;
}

// Whether a ray meets a caster other than in triangle `own`, and where; the first `skipped` places where it does are passed
// over.
bool caster_met(Caster caster, BoxRay ray, Shear shear, vec2 range, uint own, uint skipped, out Met met) {
    bool mirrored = (caster.count & MIRRORED) != 0u;
    uint n = caster.count & 255u;
    uint levels = cluster_levels(n);
    uint root = NODES + 2u * (caster.first / 3u);
    Walk walk = Walk(0xffffffffu, 0u, uvec2(1u, 0u));
    while (true) {
        bool leaf = false;
        while (walk.trail.x != 0u && !leaf) {
            next_child(walk, false);
            leaf = walk.level == levels;
            uint mask = 0u;
            if (!leaf) {
                mask = cluster_mask(ray, range, root + 2u * (level_begin(walk.level) + walk.path));
            }
            push_children(walk, mask, false);
        }
        if (!leaf) {
            return false;
        }
        uint begin = LEAF * walk.path;
        for (uint i = begin; i < min(begin + LEAF, n); i++) {
            if (caster.first + i != own && triangle_met(shear, mirrored, range, caster.first + i, met)) {
                if (skipped == 0u) {
                    return true;
                }
                skipped--;
            }
        }
    }
    return false;
}

// Whether a caster other than the surface lies on origin + t * direction with 0 < t < t_max; space relative to the eye, t in
// lengths of the direction, t_max perhaps infinite. With `snap` above 0 instead the surface becomes that of the least |t|
// below `snap`, if any.
bool occluded(vec3 origin, vec3 direction, float t_max, float snap, inout Surface surface) {
    vec2 range = snap > 0.0 ? vec2(-SEARCH, SEARCH) : vec2(0.0, t_max);
    vec3 from = top_steps(frame.eye.xyz + origin);
    BoxRay top_ray;
    top_ray.inverse = 1.0 / (divisible(direction) * vec3(STEPS_X, STEPS_Y, STEPS_Z));
    vec3 a = -from * top_ray.inverse, b = (TOP_STEPS - from) * top_ray.inverse;
    // a ray from afar starts where it enters the scene's bounds, so that rounding stays that of the bounds
    float t_in = max(max(max(min(a.x, b.x), min(a.y, b.y)), min(a.z, b.z)), 0.0);
    float t_out = min(min(min(max(a.x, b.x), max(a.y, b.y)), max(a.z, b.z)), range.y);
    if (!(t_in <= t_out)) {
        return false;
    }
    origin += t_in * direction;
    range -= t_in;
    top_ray.near_shift = -top_steps(frame.eye.xyz + origin) * top_ray.inverse;
    top_ray.far_shift = top_ray.near_shift;
    Shear shear = shear_of(direction);

    const bool wide = TOP_LEVELS > 7u;
    Walk walk = Walk(0xffffffffu, 0u, uvec2(1u, 0u));
    bool on = false;       // with the same caster
    uint passed = 0u;      // points of it that were met and do not end the walk
    while (true) {
        while (walk.trail != uvec2(0u) && !on) {
            next_child(walk, wide);
            on = walk.level == TOP_LEVELS;
            uint mask = 0u;
            if (!on) {
                mask = top_mask(top_ray, range, level_begin(walk.level) + walk.path);
            }
            push_children(walk, mask, wide);
        }
        if (!on) {
            return false;
        }
        Caster caster = read_caster(walk.path);
        Instance instance = instances[caster.instance];
        BoxRay ray = caster_ray(caster, frame.eye.xyz + origin, direction);
        Shear local = placed(shear, instance, origin);
        uint own = snap == 0.0 && caster.instance == surface.instance ? surface.triangle : NO_TRIANGLE;
        Met met;
        on = caster_met(caster, ray, local, range, own, passed, met);
        // Alpha is tested out here, and after a point that is cut away the caster is entered anew: both are rare, and a CPU
        // driver runs the code of all branches in every round of a loop.
        if (on && (!ALPHA || (caster.count & MASKED) == 0u || solid(caster.instance, met))) {
            if (snap == 0.0) {
                return true;
            }
            float t = t_in + plane_t(instance, met, origin, direction);
            if (abs(t) < snap) {
                snap = max(abs(t), 1e-30);
                surface = Surface(caster.instance, met.triangle, t);
            }
        }
        passed = on ? passed + 1u : 0u;
    }
    return false;
}
