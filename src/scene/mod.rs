//! Scenes: glTF in, triangles in clusters out. Positions are kept relative to [`Scene::origin`] so that single
//! precision suffices far from the world's origin.

mod accessor;
mod assemble;
mod builtin;
mod clusters;
mod deform;
mod file;
mod gltf;
mod images;
mod materials;
mod motion;
mod nodes;
mod pose;
mod primitive;
mod repeat;
mod track;

pub use crate::casters::{Attributes, CLUSTER_TRIANGLES, Cluster, Instance, Material, NO_TEXTURE};
pub use clusters::mesh_bounds;
pub use motion::{Changes, Motion};
pub use repeat::{MAX_COPIES, repeated};

use glam::DVec3;
use std::path::Path;

/// One glTF primitive: a run of clusters with one material, drawn by a run of instances.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mesh {
    /// First entry in [`Scene::indices`]; the clusters' index ranges tile the mesh's range in order.
    pub first_index: u32,
    /// Number of indices, three a triangle.
    pub index_count: u32,
    /// First entry in [`Scene::clusters`].
    pub first_cluster: u32,
    /// Number of clusters.
    pub cluster_count: u32,
    /// Entry in [`Scene::materials`].
    pub material: u32,
    /// First entry in [`Scene::instances`].
    pub first_instance: u32,
    /// Number of instances, at least 1.
    pub instance_count: u32,
    /// Whether the mesh casts shadows (false only for BLEND materials with [`Blend::Ignored`]).
    pub casts: bool,
    /// Whether triangles must be tested against alpha: false when no point of the mesh is cut away.
    pub alpha_tested: bool,
}

/// A scene in one pose, ready for upload and for ray tracing.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// File stem, or `builtin`.
    pub name: String,
    /// World position of the local zero: the centre of the world bounds of the scene as loaded.
    pub origin: DVec3,
    /// Vertex positions in mesh space.
    pub positions: Vec<[f32; 3]>,
    /// Parallel to `positions`.
    pub attributes: Vec<Attributes>,
    /// Absolute indices into `positions`, three a triangle.
    pub indices: Vec<u32>,
    /// All clusters, grouped by mesh.
    pub clusters: Vec<Cluster>,
    /// All primitives.
    pub meshes: Vec<Mesh>,
    /// All placements, grouped by mesh.
    pub instances: Vec<Instance>,
    /// At least one.
    pub materials: Vec<Material>,
    /// All base-colour textures, RGBA8 as stored in the file (colour sRGB, alpha linear), R in the lowest byte.
    pub texels: Vec<u32>,
    /// Lower corner of the world bounds of all instances; of a scene that moves, at all times.
    pub bounds_min: DVec3,
    /// Upper corner.
    pub bounds_max: DVec3,
    /// Things that were skipped, one sentence each.
    pub warnings: Vec<String>,
}

impl Scene {
    /// Length of the diagonal of the world bounds.
    pub fn diagonal(&self) -> f64 {
        (self.bounds_max - self.bounds_min).length()
    }

    /// Triangles stored once each.
    pub fn unique_triangles(&self) -> u64 {
        self.indices.len() as u64 / 3
    }

    /// Triangles counted once for each instance.
    pub fn drawn_triangles(&self) -> u64 {
        self.meshes.iter().map(|m| u64::from(m.index_count / 3) * u64::from(m.instance_count)).sum()
    }
}

/// What BLEND materials are as casters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Blend {
    /// They hold back all light where alpha is 0.5 and more, and none elsewhere.
    Tested,
    /// They cast no shadows.
    Ignored,
    /// They hold back the share alpha of the light ([`Material::translucent`]) for rays on the CPU and methods that can tell;
    /// for others they are as with [`Blend::Tested`].
    Translucent,
}

/// How a glTF file is turned into a [`Scene`].
#[derive(Debug, Clone, PartialEq)]
pub struct LoadOptions {
    /// Time in seconds at which the file's first animation is posed, also at 0. Times outside 0 to the animation's
    /// duration wrap around. Without animations the scene stands as stored.
    pub time_s: f64,
    /// What BLEND materials are as casters.
    pub blend: Blend,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self { time_s: 0.0, blend: Blend::Tested }
    }
}

/// A scene file that cannot be used.
#[derive(Debug, Clone, thiserror::Error)]
#[error("{path}: {what}")]
pub struct SceneError {
    /// The file as it was named.
    pub path: String,
    /// The cause in one clause, with the offending value and what is allowed.
    pub what: String,
}

/// Loads a `.gltf` or `.glb` file, glTF 2.0, with its external or embedded buffers and PNG or JPEG images.
///
/// Shown are the triangles of the default scene: placed by their nodes, or posed on the CPU where a skin or morph
/// targets move them. Primitives whose alpha is below the cutoff everywhere, points, lines, triangles of zero area
/// and instances of scale 0 are left out, each with a sentence in [`Scene::warnings`]. Normals are not read.
///
/// # Errors
/// The file, a buffer or an image cannot be read; the file is cut off or malformed; it requires an extension that is
/// not supported; an index, a range or a position is invalid; nodes form a cycle; nothing is left to show; textures
/// with tested alpha exceed 120 MiB; `time_s` is not finite.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Scene, SceneError> {
    gltf::load(path, options)
}

/// Loads like [`load`], and what moves the scene where its file's first animation moves anything shown.
///
/// The bounds then hold at all times, parts that the animation deforms keep triangles that have no area at the start,
/// and instances that it moves stay at scale 0.
///
/// # Errors
/// As [`load`], and where the animation takes a part to a place that is not finite.
pub fn load_moving(path: &Path, options: &LoadOptions) -> Result<(Scene, Option<Motion>), SceneError> {
    gltf::load_moving(path, options)
}

/// The built-in scene.
pub fn builtin() -> Scene {
    builtin::scene()
}
