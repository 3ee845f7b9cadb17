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
    pub light_x: [f32; 4],
    pub light_y: [f32; 4],
    pub light_z: [f32; 4],
    pub eye_page: [i32; 4],
    pub anchor_page: [i32; 4],
    pub page: [f32; 4],
    pub rule: [f32; 4],
    pub size: [u32; 4],
}

/// One page of the quadtree; see `glsl/shared/structs.glsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct Node {
    pub key: u32,
    pub own: u32,
    pub below: u32,
    pub rank: u32,
    pub parent: u32,
    pub page: u32,
    pub child: [u32; 4],
}

/// A page that has a layer of the atlas.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct Page {
    pub key: u32,
    pub slot: u32,
    pub node: u32,
    pub admitted: u32,
    pub origin: [f32; 2],
    pub scale: f32,
    pub pad: u32,
}

/// Counters of one frame; they keep counting beyond the capacities.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct Counters {
    pub requests: [u32; 4],
    pub unique: [u32; 4],
    pub leaves: u32,
    pub nodes: u32,
    pub failed: u32,
    pub shift: u32,
    pub threshold: u32,
    pub pages: u32,
    pub admitted: u32,
    pub pairs_opaque: u32,
    pub pairs_masked: u32,
    pub pairs_asked: u32,
    pub indices: u32,
    pub triangles: u32,
    pub sorted: u32,
    pub pad: [u32; 3],
    pub roots: [u32; 4],
    pub requested: [u32; 16],
    pub resident: [u32; 16],
    pub refused: [u32; 16],
}

/// A caster: one cluster of one instance.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub struct Caster {
    /// Index of the instance.
    pub instance: u32,
    /// Index of the cluster.
    pub cluster: u32,
}

/// Bytes of a `Pair` (page, caster).
pub(crate) const PAIR_BYTES: u64 = 8;
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
    pub pages: u32,
    pub argument: u32,
}

/// Push constants of `cull_count` and `cull_emit`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct CasterPush {
    pub caster_count: u32,
    pub first_masked: u32,
}

/// Push constants of `cull_triangles`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct TrianglePush {
    pub masked: u32,
    pub first_compacted: u32,
}

/// Where a conventional map lies; see `glsl/methods/fit.glsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct Fit {
    pub row_u: [f32; 4],
    pub row_v: [f32; 4],
    pub texel: [f32; 4],
}
