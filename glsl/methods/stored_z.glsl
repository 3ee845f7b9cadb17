// The z that was stored as a depth, times what divides it there. Needs light.glsl.
float z_of(float depth) {
    if (has_position()) {
        return depth > 0.0 ? light.depth.y / depth : light.rule.z;
    }
    return (depth - light.depth.y) / light.depth.x;
}
