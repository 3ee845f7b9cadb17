// Structs that several passes share; their Rust counterparts are in src/gpu/structs.rs.

const int LEVELS = 14;

// One page of the quadtree, at the slot of its key in the page table.
struct Node {
    uint key;
    uint own;       // pixels that ask for exactly this page
    uint below;     // pixels that ask for a finer page inside this one, weighted with 2^(levels between)
    uint rank;      // bucket of pixels gained per page drawn, least of the path to the root; see allocate_rank
    uint parent;    // slot + 1
    uint page;      // index into the pages + 1, or 0
    uint child[4];  // slot + 1, or 0
};

// A page that has a layer of the atlas.
struct Page {
    uint key;
    uint slot;      // layer of the atlas
    uint node;      // slot in the page table
    uint admitted;  // 1 when its casters fit the pair budget
    vec2 origin;    // light-space xy of the corner of its texel (0, 0), relative to the scene's origin
    float scale;    // texels per world unit
    uint pad;
};

// Counters of one frame; they keep counting beyond the capacities.
struct Counters {
    uint requests[4];   // distinct keys (flags route) or de-duplicated keys (sort route), per attempt
    uint unique[4];     // sort route: distinct keys for each possible coarsening
    uint leaves;        // distinct keys asked for
    uint nodes;         // leaves and their ancestors
    uint failed;        // insertions that found the table full
    uint shift;         // levels by which all requests were coarsened because the table was too small
    uint threshold;     // least rank that is refined
    uint pages;         // pages selected
    uint admitted;      // pages drawn
    uint pairs_opaque;  // (cluster, page) pairs drawn
    uint pairs_masked;
    uint pairs_asked;   // pairs before the budget
    uint indices;       // compacted indices written or refused
    uint triangles;     // triangles drawn into pages
    uint sorted;        // entries of the sort in progress
    uint pad[3];
    uint roots[4];      // table slot + 1 of the root pages
    uint requested[16]; // per level
    uint resident[16];
    uint refused[16];
};

// A caster: one cluster of one instance.
struct Caster {
    uint instance;
    uint cluster;
};

struct Cluster {
    float center[3];
    uint first_index;
    float extent[3];
    uint triangle_count;
};

struct Instance {
    vec4 rows[3];   // world relative to the scene's origin from mesh space
    uint material;
    uint mesh;
    uint revision;  // any change: moved, deformed, other alpha
    uint flags;     // bits 0-1: policy (0 auto, 1 static, 2 always, 3 never casts), bit 2: alpha tested
};

struct Material {
    vec4 base_color;
    vec4 uv_row0;
    vec4 uv_row1;
    uint texel_offset;
    uint width;
    uint height;
    uint wrap;
    float alpha_cutoff;
    uint pad[3];
};

struct Pair {
    uint page;
    uint caster;
};

struct DrawCommand {
    uint index_count;
    uint instance_count;
    uint first_index;
    int vertex_offset;
    uint first_instance;
};
