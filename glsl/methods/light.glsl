// The light of a map method; the includer defines LIGHT_BINDING. Lengths are world units.
layout(constant_id = 1) const uint POSITION = 0u;  // 1 where the light has a position, 0 where it is parallel

// Light space of a layer: x and y across, z along its axis. Coordinates are relative to a light with a position; those of a
// parallel light are relative to a plane before all casters, and across it to the eye.
struct Face {
    vec4 x;       // unit axis; w: coordinate of the eye
    vec4 y;       // the same
    vec4 z;       // the same
    vec4 origin;  // x: z of the scene's origin
};

struct MapLight {
    Face faces[6];  // cascades share the first; a spot's first axis is that of its cone
    vec4 eye;       // relative to the scene's origin
    vec4 depth;     // stored, nearest is greatest: (x * z + y) / divisor
    vec4 rule;      // x: bias in texels, y: bias in world units, z: range, w: cosine of the cone's half angle
};

layout(std140, binding = LIGHT_BINDING) uniform LightBlock { MapLight light; };

bool has_position() { return POSITION == 1u; }

// The face whose space a layer has.
uint face_of(uint layer) { return has_position() ? layer : 0u; }

// A direction in the space of a face.
vec3 turned(uint face, vec3 v) {
    return vec3(dot(light.faces[face].x.xyz, v), dot(light.faces[face].y.xyz, v), dot(light.faces[face].z.xyz, v));
}

vec3 light_space(uint face, vec3 from_eye) {
    return turned(face, from_eye) + vec3(light.faces[face].x.w, light.faces[face].y.w, light.faces[face].z.w);
}

// What divides coordinates across the light, and the stored depth.
float divisor(float z) { return has_position() ? z : 1.0; }

float stored_depth(float z) { return (light.depth.x * z + light.depth.y) / divisor(z); }
