// Position of a caster's vertex in its page: texels relative to the page's own corner, so that a page's content depends
// on its address and its casters only.
layout(constant_id = 0) const uint PAGE_TEXELS = 128u;
layout(constant_id = 1) const uint GUTTER = 0u;
layout(std140, binding = 0) uniform FrameBlock { Frame frame; };
layout(std430, binding = 1) readonly buffer Pages { Page pages[]; };
layout(std430, binding = 2) readonly buffer Pairs { Pair pairs[]; };
layout(std430, binding = 3) readonly buffer Instances { Instance instances[]; };
layout(location = 0) in vec3 position;

// Writes gl_Position and gl_Layer; hands out the instance.
void place_vertex(out Instance instance) {
    Pair pair = pairs[gl_InstanceIndex];
    Page page = pages[pair.target >> 1];
    instance = instances[pair.instance];
    vec4 p = vec4(position, 1.0);
    vec3 world = vec3(dot(instance.rows[0], p), dot(instance.rows[1], p), dot(instance.rows[2], p));
    vec2 ls = vec2(dot(frame.light_x.xyz, world), dot(frame.light_y.xyz, world));
    vec2 texel = (ls - page.origin) * page.scale + float(GUTTER);
    float depth = (dot(frame.light_z.xyz, world) - frame.page.w) * frame.page.z;
    gl_Position = vec4(texel * (2.0 / float(PAGE_TEXELS)) - 1.0, depth, 1.0);
    gl_Layer = int((pair.target & 1u) == 0u ? page.slot : page.dynamic_slot);
}
