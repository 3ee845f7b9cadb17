// How lights see directions. Needs key.glsl and frame.glsl.

// Level-0 pages from the middle of a face to its side.
const int HALF = 1 << (ROOT_LEVEL - 1);

// A vector in light axes as face `f` sees it: rotations that bring each side of the cube to the front.
vec3 face_axes(uint f, vec3 v) {
    switch (f) {
    case 1u: return vec3(-v.x, v.y, -v.z);
    case 2u: return vec3(-v.z, v.y, v.x);
    case 3u: return vec3(v.z, v.y, -v.x);
    case 4u: return vec3(v.x, -v.z, v.y);
    case 5u: return vec3(v.x, v.z, -v.y);
    default: return v;
    }
}

vec3 light_axes(Light light, vec3 v) { return vec3(dot(light.axis_x.xyz, v), dot(light.axis_y.xyz, v), dot(light.axis_z.xyz, v)); }
