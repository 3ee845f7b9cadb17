//! Bounds of a scene's meshes.

use super::{Mesh, Scene};
use crate::casters::bounds_of;

/// Centre and half the edges of a box in mesh space that contains the boxes of all clusters of `mesh`, an entry of
/// [`Scene::meshes`].
pub fn mesh_bounds(scene: &Scene, mesh: &Mesh) -> ([f32; 3], [f32; 3]) {
    let first = mesh.first_cluster as usize;
    bounds_of(&scene.clusters[first..first + mesh.cluster_count as usize])
}
