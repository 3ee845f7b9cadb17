// Lights and their faces.
//
// Light space: x and y across the light, z along its travel. A directional light projects along z onto (x, y) in world
// units; a light with a place divides by z, so that the face spans -1 to 1. "Units" are sides of a level-0 page, from
// the middle of the face.
struct Light {
    vec4 axis_x;     // light axis in world space; of a light with a place divided by the tangent of its half opening; w: directional: place of the eye inside its level-0 page, otherwise that tangent squared
    vec4 axis_y;     // w: as x
    vec4 axis_z;     // unit axis, direction of travel; w: directional: depth of the farthest caster below the eye
    vec4 low_x;      // xyz: directional: what single precision left of axis_x
    vec4 low_y;      // the same of axis_y
    vec4 place;      // relative to the scene's origin; w: range, directional: 0
    vec4 place_low;  // xyz: what single precision left of the place
    vec4 eye;        // the eye relative to the place; w: cosine of the angle at which a spot ends, -2 without
    vec4 scale;      // x: units per projected length, y: 1 / x, z: directional: stored depth per length, otherwise near plane, w: directional: depth of the farthest caster below the scene's origin
    vec4 rule;       // x: factor on squared footprints, y: rounding of lengths along z, z: directional: units * texels by which the farthest caster moves when an axis turns by 1 rad
    ivec4 eye_page;  // xy: directional: level-0 page of the eye, of HALF x HALF around the middle
    uvec4 kind;      // x: LIGHT_*, y: 1 when it turned since the last frame, z: revision: changes when cached pages are worthless, w: finest level
};

const uint LIGHT_NONE = 0u;
const uint LIGHT_DIRECTIONAL = 1u;
const uint LIGHT_SPOT = 2u;
const uint LIGHT_CUBE = 3u;  // point lights and wide spots: six faces

// Constants of one frame and view, written by the CPU at its start. Lengths are world units unless a name says otherwise.
struct Frame {
    mat4 clip_from_eye;  // from world positions relative to the eye
    vec4 ray_corner;     // direction with unit depth through the top-left corner of the image; w: depth is w / (stored + ray_dx.w), below 0 where nearer is less
    vec4 ray_dx;         // its change per pixel to the right; w: see ray_corner
    vec4 ray_dy;         // its change per pixel down; w: derivatives are stored divided by (depth * w)
    vec4 eye;            // relative to the scene's origin
    vec4 eye_low;        // xyz: what single precision left of that, w: by how much stored depths are rounded
    uvec4 size;          // xy: image size in pixels, z: level rule (0 area, 1 min_length), w: first record of the view's lights
    uvec4 lights;        // x: slots of lights in use, y: whether any of them has a place, z: texels of a page's gutter, w: bit 0 whether levels are blended, 1 whether ranges of layers are known
    uvec4 cache;         // x: FORGET_PAGES and FORGET_CASTERS, y: number of the frame, z: frames a caster must stand still to be cached, w: cost of a page in pairs
    vec4 rule;           // x: texels per page side without gutters, y: bias in texels, z: texels by which cached content may be off, w: start of rays along the normal
    Light sun;           // the first light: uniform data is cheaper than a list, and one sun is what most scenes have
};

const uint FORGET_PAGES = 1u;
const uint FORGET_CASTERS = 2u;
