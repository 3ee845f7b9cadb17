/*
 * Umbrage: adaptive shadow maps for Vulkan. The C interface; made from src/capi, see there and README.md.
 *
 * Structs that begin with struct_size may grow at their end: set it to sizeof. Others, and all constants, stay as they
 * are within a major version. Matrices are rows first. Handles that are invalid but not null are not noticed.
 */

#ifndef UMBRAGE_H
#define UMBRAGE_H

#include <stddef.h>
#include <stdint.h>
#include <vulkan/vulkan.h>

// Bytes of the name of a purpose, its ending zero included.
#define UMBRAGE_PURPOSE_BYTES 32

// Most triangles a cluster may hold.
#define UMBRAGE_CLUSTER_TRIANGLES 128

// Marks "no texture" in Material::texel_offset.
#define UMBRAGE_NO_TEXTURE UINT32_MAX

// Bit of an instance's `flags`: the host draws it itself (crate::SceneBuffers::host_draws). Its mesh is one cluster, of
// which only the bounds matter (Meshes::add_bounds).
#define HOST_DRAWN 8

// The lights and the views of one scene. One thread at a time may use an engine; any thread may be that one.
typedef struct UmbrageEngine UmbrageEngine;

// Meshes cut into clusters, on the CPU.
typedef struct UmbrageMeshes UmbrageMeshes;

// Draws depth and normals of a scene, for hosts that have none to give.
typedef struct UmbragePrepass UmbragePrepass;

// What a call came to: UMBRAGE_OK or one of UMBRAGE_ERROR_*. After an error outputs are unchanged, and
// umbrage_last_error says what was wrong.
typedef int32_t UmbrageResult;

// What the lookup makes of the casters around a receiver: one of UMBRAGE_FILTER_*.
typedef uint32_t UmbrageFilter;

// Sides of casters that are left out, by the winding of their triangles (counter-clockwise is front).
typedef uint32_t UmbrageCull;

// How the footprint of a pixel becomes a level.
typedef uint32_t UmbrageLevelRule;

// How the pages that pixels ask for become a list; both ways give the same pages.
typedef uint32_t UmbrageRoute;

// Which pages give way when the atlas does not hold all that are asked for.
typedef uint32_t UmbragePressure;

// What a host chooses about the engine; umbrage_config_default fills it, umbrage_engine_create checks every field.
typedef struct UmbrageConfig {
    // sizeof(UmbrageConfig), as umbrage_config_default sets it.
    size_t struct_size;
    // Width in pixels that no view ever exceeds, 1 to 16384.
    uint32_t width;
    // Height in pixels that no view ever exceeds, 1 to 16384.
    uint32_t height;
    // Device memory for the atlas: one layer of page_texels^2 texels of 4 bytes a page.
    uint64_t atlas_bytes;
    // Device memory for the page table: umbrage_table_bytes of a power of two from 1024 to 131072 distinct pages that
    // pixels may ask for; beyond them all requests are coarsened.
    uint64_t page_table_bytes;
    // Side of a page in texels: 64, 128, 256 or 512.
    uint32_t page_texels;
    // Texels along each side of a page that repeat its neighbours, up to 8; at least 2, with a filter half its taps,
    // rounded up.
    uint32_t gutter;
    // Finest level that pixels may ask for, relative to one texel a pixel: -1 is half a pixel. -8 to 8.
    float level_bias;
    // Texels of the virtual map along a side, as a power of two: 15 to 30. What pixels ask for beyond it is served by
    // the finest level. Beyond 21, stored depths are coarser than texels.
    uint32_t virtual_bits;
    // Most lights at a time, 1 to 1365.
    uint32_t lights;
    // Bits of a light in the mask: 32 (a float), 8 (fractions of 255) or, without a filter, 1.
    uint32_t mask_bits;
    // Whether pixels that the map cannot decide are decided by rays against the casters; without a filter only.
    VkBool32 exact;
    // Whether rays are traced by ray queries where UmbrageDevice and UmbrageScene allow it, else through a tree of the
    // engine's own.
    VkBool32 ray_query;
    // Samples a pixel with exact: 1, 4, 8 or 16; more than one needs 8 or 32 bits of the mask.
    uint32_t samples;
    // What the lookup makes of the casters around a receiver.
    UmbrageFilter filter;
    // Width of the filter in texels, 2 to 9; without a filter it means nothing.
    uint32_t filter_taps;
    // Whether filtered visibility changes smoothly from level to level; the coarser pages are asked for too.
    VkBool32 level_blend;
    // Sides of casters that are left out.
    UmbrageCull cull;
    // The level rule.
    UmbrageLevelRule level_rule;
    // The route from pixels to the list of pages.
    UmbrageRoute route;
    // Which pages give way when the atlas is full.
    UmbragePressure pressure;
    // Share of the atlas, in percent, that a frame leaves to pages of earlier frames; 0 to 50.
    uint32_t spare_percent;
    // Most layers of the atlas drawn in a frame, 16 to 4096. A page that moving casters touch has two layers. What is
    // put off is served by coarser pages meanwhile.
    uint32_t pages_per_frame;
    // The same for frames in which the light turned, 16 to 4096; the lesser of the two holds.
    uint32_t sun_pages_per_frame;
    // Most (cluster, page) pairs drawn in a frame, 1024 to 2097152; at least umbrage_least_pairs. 44 bytes a pair,
    // twice.
    uint32_t pair_capacity;
    // What drawing a page costs beside its pairs, as a number of pairs; 0 to 1024.
    uint32_t page_cost;
    // Frames without a change after which a caster of policy auto is cached again; 1 to 10000.
    uint32_t still_frames;
    // Texels of the page that serves by which cached shadows may be off while the light turns; 0 to 16.
    float drift_texels;
    // Frames of which umbrage_counters are kept, 1 to 16: as many as the host has in flight before it asks.
    uint32_t frames_in_flight;
    // Whether pages are kept from frame to frame.
    VkBool32 cache;
    // GPU time in milliseconds towards which umbrage_steer steers; 0: none.
    float target_ms;
    // Room for the indices of culled clusters behind the scene's own, 0 to 31457280; beyond it whole clusters are
    // drawn.
    uint32_t index_capacity;
    // Threads that cull the triangles of one (cluster, page) pair: a power of two, 8 to 128. On GPUs 64, on CPUs 16.
    uint32_t cull_group;
    // Depth bias beyond the receiver plane's, in texels of the page; 0 to 16.
    float bias_texels;
    // Zero.
    uint32_t reserved;
} UmbrageConfig;

// Handles that the host made and keeps alive as long as any engine made from them.
typedef struct UmbrageDevice {
    // sizeof(UmbrageDevice).
    size_t struct_size;
    // The loader's vkGetInstanceProcAddr; all other functions are found through it.
    PFN_vkGetInstanceProcAddr get_instance_proc_addr;
    // Made with API version 1.3.
    VkInstance instance;
    // The physical device.
    VkPhysicalDevice physical_device;
    // The logical device. The functions that come before there is one do not look at it.
    VkDevice device;
    // Whether VK_EXT_debug_utils is enabled on the instance, so that passes and objects get names.
    VkBool32 debug_utils;
    // Whether what umbrage_enable_ray_queries names is enabled on the device.
    VkBool32 ray_query;
} UmbrageDevice;

// How a position is stored.
typedef uint32_t UmbragePositionFormat;

// What the engine draws: buffers that the host fills, keeps alive, and changes only between frames, ordered before the
// engine's commands. All need storage usage; positions and attributes also vertex usage, indices also index usage.
typedef struct UmbrageScene {
    // sizeof(UmbrageScene).
    size_t struct_size;
    // Vertices with positions in mesh space, as position_format, position_stride and position_offset say.
    VkBuffer positions;
    // UmbrageAttributes, one a vertex. VK_NULL_HANDLE where nothing is alpha tested.
    VkBuffer attributes;
    // 32-bit absolute indices, three a triangle (UmbrageMeshData), followed by room for index_capacity more, which the
    // engine writes: (index_count + index_capacity) * 4 bytes.
    VkBuffer indices;
    // UmbrageCluster structs.
    VkBuffer clusters;
    // Vertex lists of the clusters, as UmbrageMeshData has them.
    VkBuffer meshlets;
    // UmbrageInstance structs. Another mesh for an instance must not have more clusters than the first.
    VkBuffer instances;
    // UmbrageMeshBounds structs.
    VkBuffer meshes;
    // UmbrageMaterial structs.
    VkBuffer materials;
    // RGBA8 texels; any buffer of 4 bytes and more where nothing is textured.
    VkBuffer texels;
    // For ray queries, else VK_NULL_HANDLE: the device address (64 bits) of a bottom-level acceleration structure for
    // each mesh, over its triangles in the order of its indices, in one geometry.
    VkBuffer shapes;
    // Bytes from a vertex to the next: a multiple of 4 up to 2048 that holds a position; 0 stands for 12.
    uint32_t position_stride;
    // Bytes from the beginning of a vertex to its position: a multiple of 4, so that the position ends within the vertex.
    uint32_t position_offset;
    // How each position is stored.
    UmbragePositionFormat position_format;
    // Number of indices before the room.
    uint32_t index_count;
    // Number of instances. Room for more is kept by instances of policy never.
    uint32_t instance_count;
    // Clusters of all instances together: umbrage_meshes_caster_count.
    uint32_t caster_count;
    // Whether any instance is alpha tested.
    VkBool32 alpha_tested;
    // Zero.
    uint32_t reserved;
    // Lower corner of the casters' bounds at all times, relative to the scene's origin, which lies best in their
    // middle.
    double bounds_min[3];
    // Upper corner.
    double bounds_max[3];
    // For casters that the host draws with pipelines of its own (umbrage_record_with), else VK_NULL_HANDLE: a
    // VkDrawIndexedIndirectCommand for each instance, of storage and indirect usage. The host fills in indexCount,
    // firstIndex and vertexOffset of the instances that it draws (UMBRAGE_CAST_HOST_DRAWN), the engine, every frame, how
    // many pages each is drawn into (instanceCount) and where these are listed (firstInstance). Their meshes come last
    // (umbrage_meshes_add_bounds). Not with exact, whose rays would not see them.
    VkBuffer host_draws;
} UmbrageScene;

// How the host uses an image before the engine's commands and after them.
typedef struct UmbrageImageUse {
    // The layout in which the engine finds and leaves the image.
    VkImageLayout layout;
    // Zero.
    uint32_t reserved;
    // The stages that use it.
    VkPipelineStageFlags2 stage;
    // What they do with it.
    VkAccessFlags2 access;
} UmbrageImageUse;

// An image of the host that the engine samples: 2-D, one sample a texel, usage sampled.
typedef struct UmbrageImage {
    // The image.
    VkImage image;
    // A 2-D view of the layer below, of the depth aspect alone where the format has two.
    VkImageView view;
    // Format of the image.
    VkFormat format;
    // Samples a texel; the engine reads images of one only.
    VkSampleCountFlagBits samples;
    // Layer of the image that the view shows.
    uint32_t layer;
    // Zero.
    uint32_t reserved;
    // What used it last before the engine's commands, and what uses it first after them. Layouts other than those in
    // which shaders sample are left for SHADER_READ_ONLY_OPTIMAL and entered again.
    struct UmbrageImageUse used;
} UmbrageImage;

// What the camera saw.
typedef struct UmbrageReceiverImages {
    // Depth of the nearest surface: D16, X8_D24, D24_S8, D32 or D32_S8, of any perspective projection. Texels of the
    // far end (0 where nearer is greater, else 1) are no surface.
    struct UmbrageImage depth;
    // R32_UINT: geometric normal towards the eye in world space (umbrage_encode_normal), or an image of
    // VK_NULL_HANDLE: then normals come from the depths of neighbours.
    struct UmbrageImage normal;
} UmbrageReceiverImages;

// One view: what its camera saw and how the host uses its mask.
typedef struct UmbrageView {
    // Width of its images in pixels, 1 to the config's.
    uint32_t width;
    // Height of its images in pixels, 1 to the config's.
    uint32_t height;
    // The images that frames may come with: more than one where frames in flight have images of their own.
    const struct UmbrageReceiverImages *images;
    // Number of these, at least 1.
    size_t image_count;
    // What reads the mask after a frame, and may still read it when the next begins.
    struct UmbrageImageUse mask;
} UmbrageView;

// What kind of light: one of UMBRAGE_LIGHT_*.
typedef uint32_t UmbrageLightKind;

// A light source. Fields that its kind does not have mean nothing.
typedef struct UmbrageLight {
    // What kind of light.
    UmbrageLightKind kind;
    // Zero.
    uint32_t reserved;
    // Spot and point: world space.
    double position[3];
    // Directional and spot: direction in which the light travels, world space, any length but zero.
    double direction[3];
    // Directional: apparent diameter in degrees; the engine takes 0 only.
    double angular_diameter_deg;
    // Spot: angle from the axis at which the light begins to fade, in degrees; 0 to outer_angle_deg. Shadows do not
    // depend on it.
    double inner_angle_deg;
    // Spot: angle from the axis at which the light ends, in degrees; above 0, at most 90.
    double outer_angle_deg;
    // Spot and point: distance at which the light ends, world units, above 0.
    double range;
} UmbrageLight;

// A light of an engine, which stays the same until the light is removed; 0 is none. Its low 32 bits are its slot.
typedef uint64_t UmbrageLightId;

// What changes from frame to frame in a view. All views of a frame have the same origin.
typedef struct UmbrageFrameInput {
    // World position of the eye.
    double eye[3];
    // Rows: right, up and backward (against the view direction), unit vectors in world space at right angles.
    double view_from_world[3][3];
    // Rows of the matrix to Vulkan clip space (y down) from view space: row i times the view coordinates is clip
    // coordinate i. Any perspective projection without a shear of depth, whether nearer is less or greater, to
    // infinity or not, off centre (jitter, stereo) or not.
    double clip_from_view[4][4];
    // World position of the scene's origin.
    double origin[3];
    // Index into the view's images.
    uint32_t images;
    // Zero.
    uint32_t reserved;
} UmbrageFrameInput;

// Records draws of the host's; user: what was given beside it.
typedef void (*UmbrageDraw)(VkCommandBuffer commands, void *user);

// Counters of one frame; they keep counting beyond the capacities.
typedef struct UmbrageCounters {
    // Distinct keys (flags route) or de-duplicated keys (sort route) asked for, by each attempt.
    uint32_t requests[4];
    // Sort route: distinct keys for each possible coarsening.
    uint32_t unique[4];
    // Distinct pages asked for.
    uint32_t leaves;
    // Their ancestors in the quadtree.
    uint32_t nodes;
    // Requests that found no place in the page table.
    uint32_t failed;
    // Levels by which all requests were coarsened because the page table was too small; 0 is normal.
    uint32_t shift;
    // Least rank that is refined.
    uint32_t threshold;
    // Least rank that is refined where that needs drawing.
    uint32_t draw_threshold;
    // Where pages of the rank below end that are drawn all the same.
    uint32_t draw_order;
    // Layers to draw before the budget of pages.
    uint32_t draws_asked;
    // Pages chosen.
    uint32_t pages;
    // Chosen pages whose cached layer is still right.
    uint32_t hits;
    // Chosen pages whose cached layer was invalidated.
    uint32_t stale;
    // Pages that serve.
    uint32_t admitted;
    // Cached layers drawn.
    uint32_t drawn;
    // Layers with moving casters drawn.
    uint32_t drawn_dynamic;
    // Layers put off by the budgets of pages and pairs.
    uint32_t deferred;
    // Pages that lost their layer.
    uint32_t evicted;
    // Pages whose content became wrong.
    uint32_t invalidated;
    // (cluster, page) pairs drawn by the engine.
    uint32_t pairs_opaque;
    // The same of alpha-tested casters.
    uint32_t pairs_masked;
    // (caster, page) pairs that the host drew.
    uint32_t pairs_host;
    // Pairs before the budget.
    uint32_t pairs_asked;
    // Compacted indices written, or refused for want of room.
    uint32_t indices;
    // Triangles drawn into pages.
    uint32_t triangles;
    // Of no use outside the sort.
    uint32_t sorted;
    // Bounds of cached casters that changed.
    uint32_t changed;
    // Instances in the layer of moving casters.
    uint32_t dynamics;
    // Runs of clusters to cull, for each of the two layers.
    uint32_t items[2];
    // Faces of lights with pages, and those with pages to draw.
    uint32_t active_faces[2];
    // Faces that pixels ask for and that no page serves.
    uint32_t starved;
    // Distinct pages asked for, by level, 0 the finest.
    uint32_t requested[24];
    // Pages that serve, by level.
    uint32_t resident[24];
    // Pages asked for that a coarser one serves, by level.
    uint32_t refused[24];
} UmbrageCounters;

// Device memory for one purpose.
typedef struct UmbrageMemory {
    // What it is for, ends with a zero.
    char purpose[UMBRAGE_PURPOSE_BYTES];
    // How much it is.
    uint64_t bytes;
} UmbrageMemory;

// The triangles of one mesh.
typedef struct UmbrageTriangles {
    // Into the positions, three a triangle.
    const uint32_t *indices;
    // Number of indices: a multiple of three, not 0.
    size_t index_count;
} UmbrageTriangles;

// At most CLUSTER_TRIANGLES neighbouring triangles of one mesh with their bounds in mesh space.
typedef struct UmbrageCluster {
    // Centre of the axis-aligned bounds, mesh space.
    float center[3];
    // First entry in the indices.
    uint32_t first_index;
    // Half the size of the bounds, mesh space.
    float extent[3];
    // Number of triangles, 1 to CLUSTER_TRIANGLES; 0 where the host draws them.
    uint32_t triangle_count;
} UmbrageCluster;

// Bounds of a mesh in mesh space and its clusters.
typedef struct UmbrageMeshBounds {
    // Centre of the axis-aligned bounds of all its clusters.
    float center[3];
    // Index of its first cluster.
    uint32_t first_cluster;
    // Half the size of the bounds.
    float extent[3];
    // Number of its clusters.
    uint32_t cluster_count;
} UmbrageMeshBounds;

// Contents of the scene's buffers of the same names; owned by the UmbrageMeshes that they come from.
typedef struct UmbrageMeshData {
    // Three a triangle, absolute; the triangles of a mesh lie together, in another order than given.
    const uint32_t *indices;
    // Number of indices.
    size_t index_count;
    // Clusters, mesh by mesh.
    const struct UmbrageCluster *clusters;
    // Number of clusters.
    size_t cluster_count;
    // Bounds and clusters of each mesh.
    const struct UmbrageMeshBounds *meshes;
    // Number of meshes.
    size_t mesh_count;
    // Vertex lists of the clusters.
    const uint32_t *meshlets;
    // Number of words of these.
    size_t meshlet_word_count;
} UmbrageMeshData;

// One placement of a mesh.
typedef struct UmbrageInstance {
    // Rows of the affine 3x4 matrix from mesh space to world space relative to the scene's origin.
    float rows[3][4];
    // What single precision leaves of the translation, to be added to the rows' last column; w is 0. Zero throughout is
    // allowed: then the instance stands where its rows say.
    float low[4];
    // Entry in the materials.
    uint32_t material;
    // Entry in the meshes.
    uint32_t mesh;
    // Any change of this number tells the engine that the instance moved or deformed or that its alpha changed.
    uint32_t revision;
    // How the instance casts, a CastPolicy; bit 2: its mesh is alpha tested
    // (ALPHA_TESTED); bit 3: the host draws it (HOST_DRAWN).
    uint32_t flags;
} UmbrageInstance;

// Base colour and alpha of a surface.
typedef struct UmbrageMaterial {
    // Linear RGBA factor.
    float base_color[4];
    // First row of the texture transform: u' = x*u + y*v + z.
    float uv_row0[4];
    // Second row: v' = x*u + y*v + z.
    float uv_row1[4];
    // First texel in the texels, or NO_TEXTURE.
    uint32_t texel_offset;
    // Texture width in texels.
    uint32_t width;
    // Texture height in texels.
    uint32_t height;
    // Wrap modes: bits 0-1 for u, bits 2-3 for v; 0 repeat, 1 mirrored repeat, 2 clamp to edge.
    uint32_t wrap;
    // A point is cut away where alpha < cutoff; 0 for opaque materials, 0.5 for BLEND.
    float alpha_cutoff;
    // 1: the surface holds back the share `alpha` of the light, where a method can tell; others test it against the cutoff. 0: it
    // holds back all.
    uint32_t translucent;
    // Zero.
    uint32_t pad[2];
} UmbrageMaterial;

// One instanced draw: a mesh with all its instances.
typedef struct UmbrageMeshDraw {
    // Number of indices.
    uint32_t index_count;
    // First index.
    uint32_t first_index;
    // Number of instances.
    uint32_t instance_count;
    // First instance.
    uint32_t first_instance;
    // Whether fragments are cut away by alpha.
    VkBool32 alpha_tested;
} UmbrageMeshDraw;

// How an instance casts; bits 0 and 1 of its flags.
typedef uint32_t UmbrageCast;

// Per-vertex data that only alpha tests and shading need; parallel to the positions.
typedef struct UmbrageAttributes {
    // Texture coordinate of the base colour (the set the material names), before the texture transform.
    float uv[2];
    // Vertex colour, linear RGBA, 8 bits each, R in the lowest byte; white where the file has none.
    uint32_t color;
} UmbrageAttributes;

// Lit or shadowed.
#define UMBRAGE_FILTER_HARD 0

// The share of the filter_taps x filter_taps nearest texels.
#define UMBRAGE_FILTER_PCF 1

// The share of 16 to 32 points of a disc of filter_taps texels, turned by a hash of the pixel.
#define UMBRAGE_FILTER_POISSON 2

// The mean of filter_taps x filter_taps bilinear lookups, a texel apart.
#define UMBRAGE_FILTER_BILINEAR 3

// Both sides cast.
#define UMBRAGE_CULL_NONE 0

// Sides turned away from the light do not cast.
#define UMBRAGE_CULL_BACK 1

// Sides turned to the light do not cast.
#define UMBRAGE_CULL_FRONT 2

// log2 of the square root of the footprint's area.
#define UMBRAGE_LEVEL_RULE_AREA 0

// log2 of the shorter of the footprint's two sides.
#define UMBRAGE_LEVEL_RULE_MIN_LENGTH 1

// Flag each page in the page table at once.
#define UMBRAGE_ROUTE_FLAGS 0

// Append, radix sort, compact; at most 16 lights.
#define UMBRAGE_ROUTE_SORT 1

// Those whose samples gain least per page, counting how far each is from its wish.
#define UMBRAGE_PRESSURE_DEMAND 0

// Those that the fewest samples ask for.
#define UMBRAGE_PRESSURE_HISTOGRAM 1

// Those of the finest levels everywhere.
#define UMBRAGE_PRESSURE_LEVEL 2

// Success.
#define UMBRAGE_OK 0

// The device, or what was enabled on it, lacks something.
#define UMBRAGE_ERROR_UNSUPPORTED 1

// A value is outside what is allowed; the message names it, what was given and what is allowed.
#define UMBRAGE_ERROR_LIMIT 2

// The device has no memory left; the message says for what, and how much it was.
#define UMBRAGE_ERROR_OUT_OF_MEMORY 3

// A Vulkan call failed; the message says which, and its result.
#define UMBRAGE_ERROR_VULKAN 4

// A pointer or a handle is null or misaligned, a struct has no known size, or an array is impossibly long.
#define UMBRAGE_ERROR_ARGUMENT 5

// A defect of the library. An engine to which this happened refuses all further calls but umbrage_engine_destroy.
#define UMBRAGE_ERROR_PANIC 6

// Parallel light, such as the sun.
#define UMBRAGE_LIGHT_DIRECTIONAL 0

// Light from a point into a cone.
#define UMBRAGE_LIGHT_SPOT 1

// Light from a point into all directions.
#define UMBRAGE_LIGHT_POINT 2

// In the cached layer while it stands still, in the layer drawn every frame while it changes.
#define UMBRAGE_CAST_AUTO 0

// Always in the cached layer: each change redraws the pages it touches.
#define UMBRAGE_CAST_STATIC 1

// Always in the layer that is drawn every frame; its revision need not be kept.
#define UMBRAGE_CAST_ALWAYS 2

// Casts no shadow.
#define UMBRAGE_CAST_NEVER 3

// Bit of an instance's flags: its triangles are tested against alpha.
#define UMBRAGE_CAST_ALPHA_TESTED 4

// Bit of an instance's flags: the host draws it itself (host_draws). Its mesh is one cluster, of which only the bounds
// matter (umbrage_meshes_add_bounds).
#define UMBRAGE_CAST_HOST_DRAWN 8

// VK_FORMAT_R32G32B32_SFLOAT, 12 bytes.
#define UMBRAGE_POSITION_FLOAT32 0

// VK_FORMAT_R16G16B16A16_SFLOAT, 8 bytes; the last component is not read.
#define UMBRAGE_POSITION_FLOAT16 1

// VK_FORMAT_R16G16B16A16_SNORM, 8 bytes; the last component is not read. Meshes quantised to -1..1, which the matrices
// of their instances scale.
#define UMBRAGE_POSITION_SNORM16 2

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Fills a config with the defaults for an image of so many pixels. struct_size: sizeof(UmbrageConfig).
//
// What the caller sees to:
// config: room for struct_size bytes.
UmbrageResult umbrage_config_default(struct UmbrageConfig *config,
                                     size_t struct_size,
                                     uint32_t width,
                                     uint32_t height);

// The least pair_capacity for a number of casters; see UmbrageScene.
uint32_t umbrage_least_pairs(uint32_t casters);

// Bytes of a page table for so many distinct pages that pixels may ask for.
uint64_t umbrage_table_bytes(uint32_t requests);

// Where the samples of a pixel lie, right of and below its middle, in pixels; the same in all pixels. places: room for
// samples of them, 1, 4, 8 or 16.
//
// What the caller sees to:
// places: room for as many as samples says.
UmbrageResult umbrage_sample_places(uint32_t samples,
                                    double (*places)[2]);

// Version of the library, such as "0.1.0".
const char *umbrage_version(void);

// Whether the engine can run on a physical device; before there is a device. Otherwise UMBRAGE_ERROR_UNSUPPORTED, and
// the message names everything that is missing, one phrase a line.
//
// What the caller sees to:
// device: valid handles; its device may be null.
UmbrageResult umbrage_check_device(const struct UmbrageDevice *device);

// Switches on what the engine needs in the structs that the host passes to vkCreateDevice (API version 1.3), and what
// it uses where the device has it. Everything else in them stays as it is, so their sType must be set before.
//
// What the caller sees to:
// device: valid handles; its device may be null.
UmbrageResult umbrage_enable_features(const struct UmbrageDevice *device,
                                      VkPhysicalDeviceFeatures *features,
                                      VkPhysicalDeviceVulkan12Features *vulkan12,
                                      VkPhysicalDeviceVulkan13Features *vulkan13);

// Switches on what ray queries need, by which exact shadows are faster on devices that trace in hardware, and hands
// out the names of the device extensions (an array that lives for ever). UMBRAGE_ERROR_UNSUPPORTED where the device
// has none. The structs go to vkCreateDevice; their sType must be set before.
//
// What the caller sees to:
// device: valid handles; its device may be null.
UmbrageResult umbrage_enable_ray_queries(const struct UmbrageDevice *device,
                                         VkPhysicalDeviceVulkan12Features *vulkan12,
                                         VkPhysicalDeviceAccelerationStructureFeaturesKHR *acceleration_structure,
                                         VkPhysicalDeviceRayQueryFeaturesKHR *ray_query,
                                         const char *const **extensions,
                                         uint32_t *extension_count);

// Makes an engine and everything it needs; nothing is allocated on the device afterwards. views: what each view of a
// frame sees, 1 to 16; they share pages. Structs and arrays are not kept, Vulkan handles are.
//
// What the caller sees to:
// All handles must be valid, made with what umbrage_enable_features switches on, and outlive the engine.
UmbrageResult umbrage_engine_create(const struct UmbrageDevice *device,
                                    const struct UmbrageConfig *config,
                                    const struct UmbrageScene *scene,
                                    const struct UmbrageView *views,
                                    size_t view_count,
                                    struct UmbrageEngine **engine);

// Destroys an engine; null is allowed.
//
// What the caller sees to:
// engine: made and not destroyed, or null; no recorded frame may still be running or waiting to run.
void umbrage_engine_destroy(struct UmbrageEngine *engine);

// Adds a light, between frames. UMBRAGE_ERROR_LIMIT for a light out of range, and beyond the config's lights.
//
// What the caller sees to:
// engine: made and not destroyed.
UmbrageResult umbrage_add_light(struct UmbrageEngine *engine,
                                const struct UmbrageLight *light,
                                UmbrageLightId *id);

// Changes a light, between frames. Pages of a directional light outlive small turns (drift_texels); those of others
// are drawn anew after any change. UMBRAGE_ERROR_LIMIT also for the id of a light that was removed.
//
// What the caller sees to:
// engine: made and not destroyed.
UmbrageResult umbrage_set_light(struct UmbrageEngine *engine,
                                UmbrageLightId id,
                                const struct UmbrageLight *light);

// Removes a light, between frames; its slot may be given to another.
//
// What the caller sees to:
// engine: made and not destroyed.
UmbrageResult umbrage_remove_light(struct UmbrageEngine *engine, UmbrageLightId id);

// Forgets all pages and casters: the next frame is a first one. For hosts that recorded a frame and never submitted
// it, or changed their buffers without telling.
//
// What the caller sees to:
// engine: made and not destroyed.
UmbrageResult umbrage_forget(struct UmbrageEngine *engine);

// Records one frame; inputs: one for each view. The commands take the receivers' images from their last use and the
// masks to theirs. frame: where its number goes, or null. After an error nothing was recorded. The engine reads the
// scene's buffers in compute and vertex shaders and as vertices and indices, and writes indices and host_draws in compute
// shaders. lavapipe (22.3, 25.0) holds indirect draws recorded after these commands in the same command buffer to the
// engine's count of draws.
//
// What the caller sees to:
// commands: recording outside of rendering, on a queue with graphics and compute. Every recorded frame of an engine
// must run, once, in the order of recording and on one queue (else call umbrage_forget). Any number of frames may be
// in flight. What the host changes in its buffers is ordered before the commands and after those of the frame before.
UmbrageResult umbrage_record(struct UmbrageEngine *engine,
                             VkCommandBuffer commands,
                             const struct UmbrageFrameInput *inputs,
                             size_t input_count,
                             uint64_t *frame);

// As umbrage_record, for scenes with casters that the host draws (host_draws): draw is called once, before this returns,
// where their draws belong. It binds pipelines of the host's own with umbrage_casters in their layout and
// glsl/host/umbrage_caster.glsl in their vertex or tessellation evaluation shader, and records vkCmdDrawIndexedIndirect
// from host_draws, of one instance or of several that follow each other.
//
// The commands lie inside of dynamic rendering into a D32_SFLOAT depth attachment of many layers, without colour, of one
// sample; viewport and scissor are set, for pipelines that have them as dynamic state. Depth is tested and written by
// GREATER_OR_EQUAL, without bias; both sides cast. A fragment shader may discard. A caster whose shape changes needs another
// revision or UMBRAGE_CAST_ALWAYS, as pages are kept: let wind or level of detail not depend on the camera.
//
// What the caller sees to:
// As umbrage_record. draw calls no function of this engine, does not unwind, and leaves the command buffer inside of the same
// rendering; what it binds stays valid.
UmbrageResult umbrage_record_with(struct UmbrageEngine *engine,
                                  VkCommandBuffer commands,
                                  const struct UmbrageFrameInput *inputs,
                                  size_t input_count,
                                  UmbrageDraw draw,
                                  void *user,
                                  uint64_t *frame);

// Makes the views anew, as many as there were, for other sizes or other images; pages and lights stay. After an error
// the engine is as it was.
//
// What the caller sees to:
// As umbrage_engine_create; no recorded frame may still be running or waiting to run.
UmbrageResult umbrage_resize(struct UmbrageEngine *engine,
                             const struct UmbrageView *views,
                             size_t view_count);

// Tells how long the GPU took for a finished frame, in milliseconds, from which the engine steers its work towards
// target_ms; without a target, and for a frame whose counters are not kept, nothing happens. tiles_ms: the part of it
// spent in culling and tiles, 0 where that is not known. Call it once a frame, in order.
//
// What the caller sees to:
// engine: made and not destroyed.
UmbrageResult umbrage_steer(struct UmbrageEngine *engine,
                            uint64_t frame,
                            double gpu_ms,
                            double tiles_ms);

// Counters of a frame that the caller has waited for. UMBRAGE_ERROR_LIMIT for a frame that was not recorded, or so
// long ago that frames_in_flight later ones were. struct_size: sizeof(UmbrageCounters).
//
// What the caller sees to:
// engine: made and not destroyed. counters: room for struct_size bytes.
UmbrageResult umbrage_counters(const struct UmbrageEngine *engine,
                               uint64_t frame,
                               struct UmbrageCounters *counters,
                               size_t struct_size);

// Device memory by purpose. memory: null to ask for the number of purposes, else room for *count of them. *count
// becomes the number that there are; UMBRAGE_ERROR_LIMIT where there is less room, which then is filled.
//
// What the caller sees to:
// engine: made and not destroyed.
UmbrageResult umbrage_memory(const struct UmbrageEngine *engine,
                             struct UmbrageMemory *memory,
                             uint32_t *count);

// What shaders of the host bind to look shadows up themselves in a view, after the commands of its frame and before
// those of the next: glsl/host/umbrage.glsl. layout: for pipeline layouts. set: bound at the number that the shader
// calls UMBRAGE_SET. They change with umbrage_resize.
//
// What the caller sees to:
// engine: made and not destroyed.
UmbrageResult umbrage_lookup(const struct UmbrageEngine *engine,
                             uint32_t view,
                             VkDescriptorSetLayout *layout,
                             VkDescriptorSet *set);

// What pipelines of the host bind to draw casters in umbrage_record_with: glsl/host/umbrage_caster.glsl. set: bound at
// the number that the shader calls UMBRAGE_CASTER_SET. UMBRAGE_ERROR_LIMIT where the scene has no host_draws.
//
// What the caller sees to:
// engine: made and not destroyed.
UmbrageResult umbrage_casters(const struct UmbrageEngine *engine,
                              VkDescriptorSetLayout *layout,
                              VkDescriptorSet *set);

// The mask of a view, of its size, and a view of all its layers (VK_IMAGE_VIEW_TYPE_2D_ARRAY): R32_UINT images of sampled,
// storage and transfer source usage with mask_bits for each light, in the order of slots from the lowest bits of the
// first layer: slot i has the bits from i * mask_bits % 32 on in layer i * mask_bits / 32. 1 lit, 0 shadowed or not reached by the light, 1 where there is no surface,
// shares with a filter or several samples a pixel. With 32 bits the words are floats, and layer i is the light of slot
// i. They change with umbrage_resize.
//
// What the caller sees to:
// engine: made and not destroyed.
UmbrageResult umbrage_mask(const struct UmbrageEngine *engine,
                           uint32_t view,
                           VkImage *image,
                           VkImageView *image_view);

// The message of the last failure on the calling thread: UTF-8, empty before the first one. It stays as it is until
// another call fails on this thread; calls that succeed do not clear it. Never null.
const char *umbrage_last_error(void);

// Slot of a light: its place in the mask and what the lookup in a shader takes.
uint32_t umbrage_light_slot(UmbrageLightId light);

// Cuts meshes into clusters. positions: of all vertices, mesh space. UMBRAGE_ERROR_LIMIT for a mesh without triangles,
// an index beyond the positions and a position that is not finite. The pointers are not kept.
//
// What the caller sees to:
// Pointers to as many elements as their counts say.
UmbrageResult umbrage_meshes_create(const float (*positions)[3],
                                    size_t position_count,
                                    const struct UmbrageTriangles *meshes,
                                    size_t mesh_count,
                                    struct UmbrageMeshes **made);

// Adds a mesh that the host draws itself (UMBRAGE_CAST_HOST_DRAWN). low, high: corners of what it ever covers, displaced in
// whatever way, in mesh space, three floats each. mesh: where its number goes. What umbrage_meshes_data gave before is no longer valid.
// UMBRAGE_ERROR_LIMIT for corners that are not finite or not in this order.
//
// What the caller sees to:
// meshes: made and not destroyed. low, high: three floats each.
UmbrageResult umbrage_meshes_add_bounds(struct UmbrageMeshes *meshes,
                                        const float *low,
                                        const float *high,
                                        uint32_t *mesh);

// Says where the data lie; valid until the meshes are changed or destroyed.
//
// What the caller sees to:
// meshes: made and not destroyed.
UmbrageResult umbrage_meshes_data(const struct UmbrageMeshes *meshes, struct UmbrageMeshData *data);

// Clusters of all these instances together: caster_count of UmbrageScene. UMBRAGE_ERROR_LIMIT for an instance of a
// mesh that is not there, and for 2^32 clusters and more.
//
// What the caller sees to:
// meshes: made and not destroyed. instances: as many as instance_count says.
UmbrageResult umbrage_meshes_caster_count(const struct UmbrageMeshes *meshes,
                                          const struct UmbrageInstance *instances,
                                          size_t instance_count,
                                          uint32_t *caster_count);

// Frees meshes; null is allowed.
//
// What the caller sees to:
// meshes: made and not destroyed, or null.
void umbrage_meshes_destroy(struct UmbrageMeshes *meshes);

// Makes an instance of policy auto. rows: of the affine matrix from mesh space to world space relative to the scene's
// origin, double precision, of which the instance keeps about 48 bits of the translation.
//
// What the caller sees to:
// rows: three.
UmbrageResult umbrage_instance_init(struct UmbrageInstance *instance,
                                    const double (*rows)[4],
                                    uint32_t mesh,
                                    uint32_t material);

// Makes a white, opaque material without a texture.
//
// What the caller sees to:
// material: room for one.
UmbrageResult umbrage_material_init(struct UmbrageMaterial *material);

// Makes images of width x height pixels, 1 to 16384 each, and the pipelines.
//
// What the caller sees to:
// As umbrage_engine_create.
UmbrageResult umbrage_prepass_create(const struct UmbrageDevice *device,
                                     const struct UmbrageScene *scene,
                                     uint32_t width,
                                     uint32_t height,
                                     struct UmbragePrepass **prepass);

// Destroys a prepass; null is allowed.
//
// What the caller sees to:
// prepass: made and not destroyed, or null; nothing recorded may still be running or waiting to run.
void umbrage_prepass_destroy(struct UmbragePrepass *prepass);

// Its depth and normals, as views take them.
//
// What the caller sees to:
// prepass: made and not destroyed.
UmbrageResult umbrage_prepass_images(const struct UmbragePrepass *prepass,
                                     struct UmbrageReceiverImages *images);

// Draws; leaves the images readable by compute shaders. The projection must have reversed depth.
//
// What the caller sees to:
// prepass: made and not destroyed. commands: recording outside of rendering. Frames must run in the order they were
// recorded. draws: inside of the scene's indices and instances, as many as draw_count says.
UmbrageResult umbrage_prepass_record(const struct UmbragePrepass *prepass,
                                     VkCommandBuffer commands,
                                     const struct UmbrageFrameInput *input,
                                     const struct UmbrageMeshDraw *draws,
                                     size_t draw_count);

// Packs a unit vector as the normal image holds it.
uint32_t umbrage_encode_normal(float x, float y, float z);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* UMBRAGE_H */
