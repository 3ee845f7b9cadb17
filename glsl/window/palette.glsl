// Colours in the order of src/window/palette.rs, and the lights that a picture is shaded with.
const uint SUN = 0u;
const uint SKY_AMBIENT = 1u;
const uint GROUND_AMBIENT = 2u;
const uint SKY_ZENITH = 3u;
const uint SKY_HORIZON = 4u;
const uint SKY_GROUND = 5u;
const uint NOTHING = 6u;
const uint STATE_CACHED = 7u;
const uint STATE_DRAWN = 8u;
const uint STATE_COARSER = 9u;
const uint LEVELS_FIRST = 10u;
const uint LEVEL_COLORS = 12u;

struct ShadeLight {
    vec4 place;      // relative to the eye; w: range
    vec4 direction;  // of travel, unit; w: LIGHT_*
    vec4 cone;       // cosines of the angles at which a spot begins to fade and ends
};

const float LIGHT_SUN = 0.0;
const float LIGHT_CONE = 1.0;
