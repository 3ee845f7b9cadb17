// Importance functions (Rosen 2012, sec. 5); a cell's importance is the product of those that are switched on.
layout(push_constant) uniform Push {
    vec2 nearness;     // importance by distance: x / depth along the view - y
    float normal;      // what facing the eye adds
    float edge;        // importance left to where there is no shadow edge
    uint view;         // 1: where the camera sees nothing, there is none
    uint stride;       // of the pixels that are looked at
};

// Least importance of what is seen: cells without any are taken out of the map.
const float LEAST = 1e-6;

// 5.2 and 5.4. `depth`: along the view direction.
float seen_importance(vec3 from_eye, vec3 normal_there, float depth) {
    float facing = clamp(-dot(normal_there, normalize(from_eye)), 0.0, 1.0);
    return max(nearness.x / depth - nearness.y, LEAST) * (1.0 + normal * facing);
}
