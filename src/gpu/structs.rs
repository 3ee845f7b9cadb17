//! Structs shared with GLSL; `tests/layout.rs` compares them with the committed SPIR-V. Push constants of a single word
//! have no struct.

use bytemuck::{Pod, Zeroable};

/// Constants of one frame; see `glsl/shared/frame.glsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct Frame {
    pub clip_from_eye: [[f32; 4]; 4],
    pub ray_corner: [f32; 4],
    pub ray_dx: [f32; 4],
    pub ray_dy: [f32; 4],
    pub eye: [f32; 4],
    pub eye_low: [f32; 4],
    pub size: [u32; 4],
    pub lights: [u32; 4],
    pub cache: [u32; 4],
    pub rule: [f32; 4],
    pub sun: LightRecord,
}

/// A light as one view needs it; see `glsl/shared/light.glsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct LightRecord {
    pub axis_x: [f32; 4],
    pub axis_y: [f32; 4],
    pub axis_z: [f32; 4],
    pub low_x: [f32; 4],
    pub low_y: [f32; 4],
    pub place: [f32; 4],
    pub place_low: [f32; 4],
    pub eye: [f32; 4],
    pub scale: [f32; 4],
    pub rule: [f32; 4],
    pub eye_page: [i32; 4],
    pub kind: [u32; 4],
}

/// Values of `LightRecord::kind[0]`.
#[doc(hidden)]
pub mod light_kind {
    pub const NONE: u32 = 0;
    pub const DIRECTIONAL: u32 = 1;
    pub const SPOT: u32 = 2;
    pub const CUBE: u32 = 3;
}

/// Bits of `Frame::cache[0]`.
pub(crate) mod frame_flags {
    pub(crate) const FORGET_PAGES: u32 = 1;
    pub(crate) const FORGET_CASTERS: u32 = 2;
    pub(crate) const LIGHT_MOVED: u32 = 4;
}

/// One page of the quadtree; see `glsl/shared/structs.glsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct Node {
    pub own: u32,
    pub below: u32,
    pub cost: u32,
    pub ranks: u32,
    pub parent: u32,
    pub page: u32,
    pub slot: u32,
    pub marks: u32,
    pub child: [u32; 4],
}

/// A page chosen in a frame.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct Page {
    pub key: [u32; 2],
    pub node: u32,
    pub slot: u32,
    pub dynamic_slot: u32,
    pub draws: u32,
    pub admitted: u32,
    pub turned: u32,
    pub scale: f32,
    pub pad: u32,
    pub origin: [f32; 2],
}

/// A layer of the atlas, from frame to frame.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct Slot {
    pub axis_x: [f32; 3],
    pub revision: u32,
    pub axis_z: [f32; 3],
    pub valid: u32,
    pub key: [u32; 2],
    pub seen: u32,
    pub used: u32,
}

/// What is known of an instance from the frames before.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct Tracked {
    pub rows: [[f32; 4]; 3],
    pub low: [f32; 4],
    pub center: [f32; 4],
    pub reach: [f32; 4],
    pub material: u32,
    pub revision: u32,
    pub flags: u32,
    pub state: u32,
    pub since: u32,
    pub patience: u32,
    pub mesh: u32,
    pub pad: u32,
}

/// Counters of one frame; they keep counting beyond the capacities.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub struct Counters {
    /// Distinct keys (flags route) or de-duplicated keys (sort route) asked for, by each attempt.
    pub requests: [u32; 4],
    /// Sort route: distinct keys for each possible coarsening.
    pub unique: [u32; 4],
    /// Distinct pages asked for.
    pub leaves: u32,
    /// Their ancestors in the quadtree.
    pub nodes: u32,
    /// Requests that found no place in the page table.
    pub failed: u32,
    /// Levels by which all requests were coarsened because the page table was too small; 0 is normal.
    pub shift: u32,
    /// Least rank that is refined.
    pub threshold: u32,
    /// Least rank that is refined where that needs drawing.
    pub draw_threshold: u32,
    /// Where pages of the rank below end that are drawn all the same.
    pub draw_order: u32,
    /// Layers to draw before the budget of pages.
    pub draws_asked: u32,
    /// Pages chosen.
    pub pages: u32,
    /// Chosen pages whose cached layer is still right.
    pub hits: u32,
    /// Chosen pages whose cached layer was invalidated.
    pub stale: u32,
    /// Pages that serve.
    pub admitted: u32,
    /// Cached layers drawn.
    pub drawn: u32,
    /// Layers with moving casters drawn.
    pub drawn_dynamic: u32,
    /// Layers put off by the budgets of pages and pairs.
    pub deferred: u32,
    /// Pages that lost their layer.
    pub evicted: u32,
    /// Pages whose content became wrong.
    pub invalidated: u32,
    /// (cluster, page) pairs drawn by the engine.
    pub pairs_opaque: u32,
    /// The same of alpha-tested casters.
    pub pairs_masked: u32,
    /// (caster, page) pairs that the host drew.
    pub pairs_host: u32,
    /// Pairs before the budget.
    pub pairs_asked: u32,
    /// Compacted indices written, or refused for want of room.
    pub indices: u32,
    /// Triangles drawn into pages.
    pub triangles: u32,
    /// Of no use outside the sort.
    pub sorted: u32,
    /// Bounds of cached casters that changed.
    pub changed: u32,
    /// Instances in the layer of moving casters.
    pub dynamics: u32,
    /// Runs of clusters to cull, for each of the two layers.
    pub items: [u32; 2],
    /// Faces of lights with pages, and those with pages to draw.
    pub active_faces: [u32; 2],
    /// Faces that pixels ask for and that no page serves.
    pub starved: u32,
    /// Distinct pages asked for, by level, 0 the finest.
    pub requested: [u32; 24],
    /// Pages that serve, by level.
    pub resident: [u32; 24],
    /// Pages asked for that a coarser one serves, by level.
    pub refused: [u32; 24],
}

/// Bounds of a mesh in mesh space and its clusters.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct MeshBounds {
    /// Centre of the axis-aligned bounds of all its clusters.
    pub center: [f32; 3],
    /// Index of its first cluster.
    pub first_cluster: u32,
    /// Half the size of the bounds.
    pub extent: [f32; 3],
    /// Number of its clusters.
    pub cluster_count: u32,
}

/// Bytes of an `Item`, a run of clusters of an instance.
pub(crate) const ITEM_BYTES: u64 = 8;
/// Clusters of a run.
pub(crate) const RUN: u32 = 8;
/// Lists of pairs: opaque, alpha tested, drawn by the host.
pub(crate) const PAIR_KINDS: u64 = 3;
/// Bytes of a `Pair` (target, instance, cluster, anchor).
pub(crate) const PAIR_BYTES: u64 = 24;
/// Bytes of a `VkDrawIndexedIndirectCommand`.
pub(crate) const COMMAND_BYTES: u64 = 20;

/// Push constants of `request`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct RequestPush {
    pub attempt: u32,
    pub shift: u32,
}

/// Push constants of `request_retry`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct RetryPush {
    pub attempt: u32,
    pub shift: u32,
    pub groups_x: u32,
    pub groups_y: u32,
    pub argument: u32,
}

/// Push constants of `sort_prepare`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct PreparePush {
    pub capacity: u32,
    pub argument: u32,
}

/// Push constants of `allocate_choose`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct ChoosePush {
    pub draw_budget: i32,
    pub step: u32,
}

/// Push constants of `cull_prepare`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct ItemPush {
    pub layer: u32,
    pub argument: u32,
}

/// Push constants of `cull_triangles`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct TrianglePush {
    pub masked: u32,
    pub first_compacted: u32,
}

/// Where one layer of a map lies; see `glsl/methods/fit.glsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct Fit {
    pub row_u: [f32; 4],
    pub row_v: [f32; 4],
    pub row_w: [f32; 4],
    pub texel: [f32; 4],
}

/// What was found for the tiles that are drawn; see `glsl/methods/tile.glsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct TileCounts {
    pub groups: [u32; 4],
    pub items: u32,
    pub opaque: u32,
    pub masked: u32,
    pub dropped: u32,
}

/// Light space of a layer of a map; see `glsl/methods/light.glsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct Face {
    pub x: [f32; 4],
    pub y: [f32; 4],
    pub z: [f32; 4],
    pub origin: [f32; 4],
}

/// The light of a map method; see `glsl/methods/light.glsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct MapLight {
    pub faces: [Face; 6],
    pub eye: [f32; 4],
    pub depth: [f32; 4],
    pub rule: [f32; 4],
}

/// How the layers of a map divide the image; see `glsl/methods/slices.glsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct Slices {
    pub extremes: [u32; 2],
    pub outside: u32,
    pub splits: [f32; 9],
    pub exits: [[f32; 4]; 5],
}

/// How large a texel looks in one pixel; see `glsl/shared/sampling.glsl`. Values above 1 are undersampling.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct SamplingError {
    /// Length of a texel's side along the map's first axis, in pixels.
    pub s: f32,
    /// The same along its second axis.
    pub t: f32,
    /// What `s` would be where the surface met eye and light at equal angles: its perspective part (book, 3.2.3).
    pub perspective_s: f32,
    /// The perspective part of `t`.
    pub perspective_t: f32,
    /// Part of the map that serves: its layer, or the place of its page; [`Self::NO_PART`] where nothing looks up.
    pub part: u32,
}

impl SamplingError {
    /// [`Self::part`] of a pixel that looks nothing up.
    pub const NO_PART: u32 = u32::MAX;
}

/// The surface under a pixel as a map would hold it; see `glsl/methods/forward.glsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct ForwardSample {
    /// Place along u from the layer's corner, in 1/256 texel.
    pub at_x: i32,
    /// The same along v.
    pub at_y: i32,
    /// Greatest stored depth there that matches.
    pub nearest: f32,
    /// Least stored depth there that matches.
    pub farthest: f32,
    /// Change of both to the next texel along u, on the surface's plane.
    pub slope_x: f32,
    /// The same along v.
    pub slope_y: f32,
    /// Layer of the map; from [`Self::OUTSIDE`] on none.
    pub layer: u32,
    #[doc(hidden)]
    pub pad: u32,
}

impl ForwardSample {
    /// [`Self::layer`] of a surface that no layer holds.
    pub const OUTSIDE: u32 = u32::MAX - 2;
    /// [`Self::layer`] of a surface that the light does not shine on.
    pub const UNLIT: u32 = u32::MAX - 1;
}

/// What splatting a map did; see `glsl/methods/forward.glsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct ForwardCounts {
    pub vertices: u32,
    pub instances: u32,
    pub first_vertex: u32,
    pub first_instance: u32,
    pub holes: u32,
}

/// A warp of a map; see `glsl/methods/warp.glsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct WarpRecord {
    pub bounds: [u32; 4],
    pub slopes: [u32; 2],
    pub depths: [u32; 2],
    pub costs: [u32; 2],
    pub middle: f32,
    pub line: f32,
    pub distance: f32,
    pub extent: f32,
    pub warped: u32,
    pub through_eye: u32,
    pub axis: [f32; 2],
    pub sine: f32,
    pub moved: u32,
    pub fit: Fit,
}

/// The plane that a warp is optimal for; see `glsl/methods/plane.glsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct DominantPlane {
    pub plane: [f32; 4],
    pub forward: [f32; 4],
    pub sums: [u32; 8],
    pub bin: u32,
    pub count: u32,
    pub pad: [u32; 2],
}

/// Push constants of `methods/warp_measure.comp`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct WarpMeasure {
    pub step: u32,
    pub resolution: f32,
}

/// Push constants of `methods/warp_choose.comp`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct WarpPush {
    pub step: u32,
    pub resolution: f32,
    pub border: f32,
    pub parameter: f32,
    pub always: u32,
}

/// Where a quadtree of pages lies in a frame; see `glsl/methods/quadtree.glsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct VirtualMap {
    pub eye_page: [i32; 2],
    pub eye_inside: [f32; 2],
    pub page: f32,
    pub square: f32,
    pub rule: u32,
    pub frame: u32,
    pub reset: u32,
}

/// A node of such a tree.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct Cell {
    pub child: [u32; 4],
    pub tile: u32,
}

/// What a tile of such a tree holds.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct TilePage {
    pub depth: u32,
    pub x: u32,
    pub y: u32,
    pub parent: u32,
    pub used: u32,
    pub value: u32,
    pub seen: u32,
    pub benefit: [u32; 4],
    pub texels: [u32; 4],
}

/// What a frame of an adaptive shadow map did; see `glsl/methods/asm_counts.glsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct AsmCounts {
    pub resident: u32,
    pub made: u32,
    pub evicted: u32,
    pub displaced: u32,
    pub waiting: u32,
    pub stale: u32,
}

/// What a frame of an adaptive shadow map of many iterations did; see `glsl/methods/asm_gpu_counts.glsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct AsmGpuCounts {
    pub resident: u32,
    pub iterations: u32,
    pub requested: u32,
    pub outstanding: u32,
    pub cells: u32,
    pub asking: u32,
}

/// Push constants of `methods/asm_gpu_allocate.comp`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct AsmGpuPush {
    pub first: u32,
    pub last: u32,
    pub groups: [u32; 2],
    pub argument: u32,
}

/// Push constants of `methods/asm_analyze.comp`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct AnalyzePush {
    pub step: [u32; 2],
    pub offset: [u32; 2],
}

/// Push constants of `methods/asm_choose.comp`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct AsmPush {
    pub most: u32,
    pub threshold: u32,
    pub overhead: f32,
}

/// Push constants of `methods/asm_stale.comp`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct StalePush {
    pub instance_count: u32,
    pub tiles: u32,
    pub reset: u32,
}

/// An edge of a mesh; see `glsl/methods/silhouette.glsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct Edge {
    pub ends: [u32; 2],
    pub first: u32,
    pub count: u32,
}

/// Edges of an instance that one workgroup looks at; see `glsl/methods/silhouette.glsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct EdgeRun {
    pub instance: u32,
    pub first: u32,
    pub count: u32,
}

/// Push constants of `methods/temporal_jitter.comp`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct TemporalJitter {
    pub turn: [f32; 2],
    pub shift: [f32; 2],
}

/// Push constants of `methods/temporal_blend.comp`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct TemporalPush {
    pub clip_before: [[f32; 4]; 4],
    pub eye_moved: [f32; 4],
    pub exponent: f32,
    pub memory: f32,
    pub rejection: f32,
    pub moved: u32,
    pub side: u32,
    pub history: u32,
}

/// Push constants of `methods/rtw_backward.comp` and `methods/rtw_forward.comp`; see `glsl/methods/rtw_importance.glsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct RtwPush {
    pub nearness: [f32; 2],
    pub normal: f32,
    pub edge: f32,
    pub view: u32,
    pub stride: u32,
}

/// A light that the window shades with; see `glsl/window/palette.glsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct ShadeLight {
    pub place: [f32; 4],
    pub direction: [f32; 4],
    pub cone: [f32; 4],
}

/// Push constants of `window/shade.comp`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct ShadePush {
    pub up: [f32; 4],
    pub count: u32,
    pub bits: u32,
    pub show: u32,
    pub sun_at: f32,
}

/// Push constants of `window/atlas.comp`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct AtlasPush {
    pub columns: u32,
    pub cell: u32,
}

/// A tile of a tree that is refined; see `glsl/methods/tree.glsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct Region {
    pub low: [u32; 2],
    pub size: [u32; 2],
    pub samples: [u32; 4],
    pub splits: u32,
    pub priority: u32,
    pub unmet: u32,
    pub changed: u32,
}

/// Lists of a tree; see `glsl/methods/tree.glsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct TreeState {
    pub counts: [u32; 20],
    pub refused: [u32; 20],
}

/// Push constants of `methods/tree_measure.comp`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct TreeMeasurePush {
    pub round: u32,
    pub drop: f32,
    pub threshold: u32,
    pub start: u32,
}

/// Push constants of `methods/tree_request.comp`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct TreeRequestPush {
    pub texels: f32,
    pub density: f32,
}

/// Push constants of `methods/qvsm_compare.comp`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct QvsmPush {
    pub round: u32,
    pub start: u32,
}

/// Push constants of `methods/tiled_importance.comp`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct ImportancePush {
    pub near: f32,
    pub jumps: f32,
}
