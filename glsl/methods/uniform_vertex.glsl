// Position of a caster's vertex in a conventional map.
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(std430, binding = 1) readonly buffer FitBlock { Fit fit; };
layout(std430, binding = 2) readonly buffer Instances { Instance instances[]; };
layout(location = 0) in vec3 position;

void place_vertex(out Instance instance) {
    instance = instances[gl_InstanceIndex];
    vec4 p = vec4(position, 1.0);
    vec3 world = vec3(dot(instance.rows[0], p), dot(instance.rows[1], p), dot(instance.rows[2], p));
    vec3 from_eye = world - frame.eye.xyz;
    vec3 ls = vec3(dot(frame.light_x.xyz, from_eye), dot(frame.light_y.xyz, from_eye), 1.0);
    float depth = (dot(frame.light_z.xyz, world) - frame.page.w) * frame.page.z;
    gl_Position = vec4(2.0 * vec2(dot(fit.row_u.xyz, ls), dot(fit.row_v.xyz, ls)) - 1.0, depth, 1.0);
}
