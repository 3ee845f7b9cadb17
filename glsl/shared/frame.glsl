// Constants of one frame, written by the CPU at its start. Lengths are world units unless a name says otherwise.
// Light space: x and y across the light, z along its travel; "page units" are sides of a level-0 page.
struct Frame {
    mat4 clip_from_eye;   // from world positions relative to the eye; reversed depth
    vec4 ray_corner;      // direction with unit depth through the top-left corner of the image; w: near plane
    vec4 ray_dx;          // its change per pixel to the right; w: far plane
    vec4 ray_dy;          // its change per pixel down; w: derivatives are stored divided by (depth * w)
    vec4 eye;             // relative to the scene's origin
    vec4 light_x;         // unit axis; w: fraction of the level-0 page in which the eye lies, x
    vec4 light_y;         // unit axis; w: the same, y
    vec4 light_z;         // unit axis, direction of travel; w: light depth of the eye above the nearest caster
    ivec4 eye_page;       // xy: level-0 page of the eye relative to the anchor
    ivec4 anchor_page;    // xy: level-0 page, on the grid through the scene's origin, where keys start
    vec4 page;            // x: side of a level-0 page, y: 1 / x, z: 1 / depth range of the casters, w: nearest caster depth
    vec4 rule;            // x: factor on squared footprints, y: bias in texels, z: bias in world units, w: texels per page side
    uvec4 size;           // xy: image size in pixels, z: level rule (0 area, 1 min_length), w: unused
    uvec4 cache;          // x: FORGET_PAGES, FORGET_CASTERS and LIGHT_MOVED, y: number of the frame, z: frames a caster must stand still to be cached, w: cost of a page in pairs
    vec4 drift;           // x: texels of level 0 that the farthest caster moves by when a light axis turns by 1 rad, y: texels by which cached content may be off
};

const int ROOT_LEVEL = 13;
const uint FORGET_PAGES = 1u;
const uint FORGET_CASTERS = 2u;
const uint LIGHT_MOVED = 4u;
