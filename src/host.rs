//! Everything that crosses the border between a host renderer and the engine, as plain handles.

use ash::vk;

/// What the engine draws: buffers that the host fills, keeps alive, and changes only between frames. Positions may change
/// with the bounds of their clusters and meshes and the revisions of their instances.
/// All need `STORAGE_BUFFER` usage; `positions` and `attributes` also `VERTEX_BUFFER`, `indices` also `INDEX_BUFFER`.
#[derive(Debug, Clone, Copy)]
pub struct SceneBuffers {
    /// Tightly packed `vec3` positions in mesh space.
    pub positions: vk::Buffer,
    /// 12 bytes a vertex: `vec2` texture coordinate, RGBA8 colour.
    pub attributes: vk::Buffer,
    /// 32-bit absolute indices, three a triangle, followed by room for `Config::index_capacity` more.
    pub indices: vk::Buffer,
    /// Number of indices before that room.
    pub index_count: u32,
    /// `Cluster` structs.
    pub clusters: vk::Buffer,
    /// 32-bit words: for each cluster where its meshlet begins; then meshlets: the number of distinct vertices, these as
    /// absolute indices, then a word a triangle with three 10-bit positions in that list.
    pub meshlets: vk::Buffer,
    /// `Instance` structs. A host may change them between frames, and raises `revision` where the casters changed otherwise
    /// than by matrix, mesh, material or flags. Another mesh must not have more clusters than the first. In worlds of
    /// kilometres `low` holds what single precision leaves of the translation; zero is allowed.
    pub instances: vk::Buffer,
    /// Number of instances. Room for more is kept by instances of policy [`CastPolicy::Never`].
    pub instance_count: u32,
    /// [`crate::gpu::structs::MeshBounds`] structs.
    pub meshes: vk::Buffer,
    /// `Material` structs.
    pub materials: vk::Buffer,
    /// RGBA8 texels.
    pub texels: vk::Buffer,
    /// For ray queries: the device address (64 bits) of a bottom-level acceleration structure for each mesh, over its
    /// triangles in the order of its indices, in one geometry. The host builds them and, where a mesh deforms, builds or
    /// refits them, ordered before the engine's commands as writes of acceleration structures before a build of one reads
    /// them and before compute shaders do.
    pub shapes: Option<vk::Buffer>,
    /// Number of casters: clusters of all instances together.
    pub caster_count: u32,
    /// Whether any instance is alpha tested.
    pub alpha_tested: bool,
    /// Lower corner of the casters' bounds at all times, relative to the scene's origin, which lies best in their middle.
    pub bounds_min: [f64; 3],
    /// Upper corner.
    pub bounds_max: [f64; 3],
}

/// How an instance casts; bits 0 and 1 of its `flags`.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CastPolicy {
    /// In the cached layer while it stands still, in the layer drawn every frame while it changes.
    Auto = 0,
    /// Always in the cached layer: each change redraws the pages it touches.
    Static = 1,
    /// Always in the layer that is drawn every frame; its revision need not be kept.
    Always = 2,
    /// Casts no shadow.
    Never = 3,
}

/// Bit of an instance's `flags`: its triangles are tested against alpha.
pub const ALPHA_TESTED: u32 = 4;

/// What the camera saw: images in `SHADER_READ_ONLY_OPTIMAL` when the engine's commands run.
#[derive(Debug, Clone, Copy)]
pub struct Receivers {
    /// D32 depth, reversed (near 1, far 0; 0 where there is no surface).
    pub depth: vk::ImageView,
    /// R32_UINT: geometric normal towards the eye, octahedral, two 16-bit signed fractions.
    pub normal: vk::ImageView,
    /// Width and height of both in pixels, 1 to those of [`crate::Config::size`].
    pub size: [u32; 2],
}

/// What changes from frame to frame in a view. All views of a frame have the same origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameInput {
    /// The camera; positions in world space.
    pub camera: crate::Camera,
    /// World position of the scene's origin.
    pub origin: glam::DVec3,
}
