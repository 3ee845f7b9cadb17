// Whether a triangle covers the centre of a texel, asked where that centre lies before the map bends edges, and its depth there: what
// is drawn does not depend on how edges are bent. After bent_vertex.glsl; the includer defines FETCH_BINDING, as there, and centre_of().
layout(constant_id = 2) const uint CULL = 0u;  // as in masked_fragment.glsl
layout(constant_id = 4) const uint MASKED = 0u;
layout(constant_id = 5) const uint SIDE = 2048u;
layout(std430, binding = 2) readonly buffer Instances { Instance instances[]; };
layout(std430, binding = 4) readonly buffer Materials { Material materials[]; };
layout(std430, binding = 5) readonly buffer Texels { uint texels[]; };
layout(std430, binding = FETCH_BINDING + 1) readonly buffer Indices { uint indices[]; };
layout(std430, binding = FETCH_BINDING + 2) readonly buffer Attributes { uint attributes[]; };  // three words a vertex
#include "shared/alpha.glsl"

layout(location = 0) flat in vec3 corner_a;
layout(location = 1) flat in vec3 corner_b;
layout(location = 2) flat in vec3 corner_c;
layout(location = 3) flat in uint instance_index;
layout(location = 4) flat in uint triangle;
layout(depth_less) out float gl_FragDepth;  // than that of the box

// Where corners have the centre of a texel; hands out what divides stored depths there.
vec2 centre_of(uvec2 texel, out float w);

vec2 vertex_uv(uint vertex) { return vec2(uintBitsToFloat(attributes[3u * vertex]), uintBitsToFloat(attributes[3u * vertex + 1u])); }
vec4 vertex_color(uint vertex) { return unpackUnorm4x8(attributes[3u * vertex + 2u]); }

// Whether alpha cuts the point with these shares of the corners away.
bool cut_away(Instance instance, vec3 share) {
    uvec3 vertex = uvec3(indices[3u * triangle], indices[3u * triangle + 1u], indices[3u * triangle + 2u]);
    vec2 uv = share.x * vertex_uv(vertex.x) + share.y * vertex_uv(vertex.y) + share.z * vertex_uv(vertex.z);
    vec4 color = share.x * vertex_color(vertex.x) + share.y * vertex_color(vertex.y) + share.z * vertex_color(vertex.z);
    Material material = materials[instance.material];
    return base_color(material, uv, color).a < material.alpha_cutoff;
}

bool turned_over(Instance instance) {
    return determinant(mat3(instance.rows[0].xyz, instance.rows[1].xyz, instance.rows[2].xyz)) < 0.0;
}

void main() {
    uvec2 texel = uvec2(gl_FragCoord.xy);
    float w;
    vec2 at = centre_of(texel, w);
    // twice the areas across from each corner; of an edge that two triangles share each has the negative of the other's, so
    // that no centre falls between them
    precise vec2 a = corner_a.xy - at, b = corner_b.xy - at, c = corner_c.xy - at;
    precise vec3 areas = vec3(b.x * c.y - b.y * c.x, c.x * a.y - c.y * a.x, a.x * b.y - a.y * b.x);
    float whole = areas.x + areas.y + areas.z;
    if (whole == 0.0 || !(all(greaterThanEqual(areas, vec3(0.0))) || all(lessThanEqual(areas, vec3(0.0))))) {
        discard;
    }
    vec3 share = areas / whole;
    if (CULL != 0u || MASKED != 0u) {
        Instance instance = instances[instance_index];
        // counter-clockwise where y points down
        bool front = (whole < 0.0) != turned_over(instance);
        if (CULL == 1u && !front || CULL == 2u && front || MASKED != 0u && cut_away(instance, share)) {
            discard;
        }
    }
    vec3 depths = vec3(corner_a.z, corner_b.z, corner_c.z);
    float low = min(min(depths.x, depths.y), depths.z), high = max(max(depths.x, depths.y), depths.z);
    gl_FragDepth = min(clamp(dot(share, depths), low, high) / w, gl_FragCoord.z);
}
