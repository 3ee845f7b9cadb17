// Structs that several passes share; their Rust counterparts are in src/gpu/structs.rs.

const int LEVELS = 24;

// One page of the quadtree, at the slot of its key in the page table.
struct Node {
    uint own;       // pixels that ask for exactly this page
    uint below;     // pixels that ask for a finer page inside this one, weighted with 2^(levels between)
    uint cost;      // of refining it, see refine.glsl; 0 where nothing lies below
    uint ranks;     // low half: least rank on the path to the root; high half: the same over nodes whose refining draws
    uint parent;    // slot + 1
    uint page;      // index into the pages + 1, or 0
    uint slot;      // layer of the atlas that holds it from an earlier frame + 1, or 0; STALE when it must be redrawn, TURNED
    uint marks;     // MARK_*
    uint child[4];  // slot + 1, or 0
};

const uint STALE = 0x80000000u;
const uint TURNED = 0x40000000u;   // it was drawn for a light that has turned a little since
const uint MARK_DYNAMIC = 1u;      // a moving caster touches this page
const uint MARK_DRAWN = 2u;        // this page or one below it is drawn: cached layer; << 1: dynamic layer

// A page chosen this frame.
struct Page {
    uvec2 key;
    uint node;          // slot in the page table
    uint slot;          // layer of the atlas with the casters that stand still; NONE until assigned
    uint dynamic_slot;  // layer with those that move; NONE where there are none
    uint draws;         // bit 0: the first layer must be drawn, bit 1: the second
    uint admitted;      // 1 when it serves: its draws fit the budgets; 2: they fit the pairs only
    uint turned;        // 1 when its first layer was drawn for a light that has turned a little since
    float scale;        // texels per projected length
    uint pad;
    vec2 origin;        // projected position of the corner of its texel (0, 0)
};

// A layer of the atlas; lives from frame to frame.
struct Slot {
    float axis_x[3];  // light axes for which it was drawn
    uint revision;    // of its light when it was drawn
    float axis_z[3];
    uint valid;       // 1 while its content is that of a fresh page
    uvec2 key;        // page it holds; 0: none
    uint seen;        // frame that last had its page in the quadtree
    uint used;        // frame that last chose its page
};

// What is known of an instance from the frames before.
struct Tracked {
    vec4 rows[3];
    vec4 low;
    vec4 center;      // of its bounds relative to the scene's origin, world space
    vec4 reach;       // half their size
    uint material;
    uint revision;
    uint flags;
    uint state;       // CASTER_*
    uint since;       // frame of the last change
    uint patience;    // frames to stand still before it is cached; 0 before its first start
    uint mesh;
    uint pad;
};

const uint CASTER_UNKNOWN = 0u;
const uint CASTER_NONE = 1u;     // casts no shadow
const uint CASTER_STATIC = 2u;   // in the cached layer
const uint CASTER_DYNAMIC = 3u;  // in the layer drawn every frame

// Bits of the change of an instance.
const uint CHANGED_PLACE = 1u;  // matrix, mesh, material or flags
const uint CHANGED_SHAPE = 2u;  // vertices, another mesh, or one that cast nothing before

// Counters of one frame; they keep counting beyond the capacities.
struct Counters {
    uint requests[4];   // distinct keys (flags route) or de-duplicated keys (sort route), per attempt
    uint unique[4];     // sort route: distinct keys for each possible coarsening
    uint leaves;        // distinct keys asked for
    uint nodes;         // leaves and their ancestors
    uint failed;        // insertions that found the table full
    uint shift;         // levels by which all requests were coarsened because the table was too small
    uint threshold;     // least rank that is refined
    uint draw_threshold; // least rank that is refined where that needs drawing
    uint draw_order;    // nodes of the rank below that come before this in the order of draw_order() are refined too
    uint draws_asked;   // layers to draw before the budget of pages
    uint pages;         // pages chosen
    uint hits;          // chosen pages whose cached layer is still right
    uint stale;         // chosen pages whose cached layer was invalidated
    uint admitted;      // pages that serve
    uint drawn;         // cached layers drawn
    uint drawn_dynamic; // dynamic layers drawn
    uint deferred;      // layers put off by the budgets of pages and pairs
    uint evicted;       // pages that lost their layer
    uint invalidated;   // pages whose content became wrong
    uint pairs_opaque;  // (cluster, page) pairs drawn
    uint pairs_masked;
    uint pairs_host;    // of casters that the host draws
    uint pairs_asked;   // pairs before the budget
    uint indices;       // compacted indices written or refused
    uint triangles;     // triangles drawn into pages
    uint sorted;        // entries of the sort in progress
    uint changed;       // bounds of cached casters that changed
    uint dynamics;      // instances in the dynamic layer
    uint items[2];      // runs of clusters to cull, per layer
    uint active_faces[2]; // faces with pages, and those with pages to draw
    uint starved;       // faces that pixels ask for and that no page serves
    uint requested[24]; // per level
    uint resident[24];
    uint refused[24];
};

// A run of at most RUN clusters of one instance.
struct Item {
    uint instance;
    uint first_cluster;
};

const uint RUN = 8u;

struct Cluster {
    float center[3];
    uint first_index;
    float extent[3];
    uint triangle_count;
};

// Bounds and clusters of a mesh.
struct MeshBounds {
    float center[3];
    uint first_cluster;
    float extent[3];
    uint cluster_count;
};

struct Instance {
    vec4 rows[3];   // world relative to the scene's origin from mesh space
    vec4 low;       // xyz: what single precision left of the translation
    uint material;
    uint mesh;
    uint revision;  // any change: moved, deformed, other alpha
    uint flags;     // bits 0-1: POLICY_*, bit 2: alpha tested, bit 3: drawn by the host
};

const uint POLICY_STATIC = 1u;
const uint POLICY_ALWAYS = 2u;
const uint POLICY_NEVER = 3u;
const uint ALPHA_TESTED = 4u;
const uint HOST_DRAWN = 8u;

struct Material {
    vec4 base_color;
    vec4 uv_row0;
    vec4 uv_row1;
    uint texel_offset;
    uint width;
    uint height;
    uint wrap;
    float alpha_cutoff;
    uint translucent;  // 1: alpha is the share of the light that it holds back
    uint pad[2];
};

struct Pair {
    uint target;   // 2 * page + layer
    uint instance;
    uint cluster;
    float anchor[3];  // see anchor.glsl
};

const uint PAIR_OPAQUE = 0u;
const uint PAIR_MASKED = 1u;
const uint PAIR_HOST = 2u;
const uint PAIR_KINDS = 3u;

// Which list the pairs of an instance go to.
uint pair_kind(Instance instance) {
    if ((instance.flags & HOST_DRAWN) != 0u) {
        return PAIR_HOST;
    }
    return (instance.flags & ALPHA_TESTED) != 0u ? PAIR_MASKED : PAIR_OPAQUE;
}

struct DrawCommand {
    uint index_count;
    uint instance_count;
    uint first_index;
    int vertex_offset;
    uint first_instance;
};
