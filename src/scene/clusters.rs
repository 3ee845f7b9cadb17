//! Cuts a mesh's triangles into clusters of neighbours.

use super::{CLUSTER_TRIANGLES, Cluster, Mesh, Scene};
use glam::{DVec3, Vec3};

/// Triangle counts above which both halves of a split are worth two threads.
const PARALLEL_TRIANGLES: usize = 1 << 14;

/// Reorders the triangles and returns the clusters that tile them, `first_index` counted from the first triangle.
///
/// All clusters but the last are full: each split is at the median of the longest axis of the centroids, rounded to
/// a multiple of [`CLUSTER_TRIANGLES`]. The result depends on the input alone, not on the number of threads.
pub(super) fn build(positions: &[[f32; 3]], triangles: &mut [[u32; 3]]) -> Vec<Cluster> {
    let corner = |i: u32| Vec3::from(positions[i as usize]);
    // halves before the sum: corners near the largest float must not overflow
    let centroid = |t: &[u32; 3]| t.iter().map(|&i| corner(i) / 3.0).sum();
    let mut items: Vec<Item> =
        triangles.iter().zip(0..).map(|(t, id)| Item { centroid: centroid(t), id, corners: *t }).collect();
    split(&mut items);
    for (triangle, item) in triangles.iter_mut().zip(&items) {
        *triangle = item.corners;
    }
    let chunks = triangles.chunks(CLUSTER_TRIANGLES).enumerate();
    chunks.map(|(i, chunk)| bound(positions, chunk, (i * CLUSTER_TRIANGLES * 3) as u32)).collect()
}

#[derive(Clone, Copy)]
struct Item {
    centroid: Vec3,
    id: u32,
    corners: [u32; 3],
}

fn split(items: &mut [Item]) {
    let clusters = items.len().div_ceil(CLUSTER_TRIANGLES);
    if clusters < 2 {
        // file order keeps shared vertices near each other
        items.sort_unstable_by_key(|item| item.id);
        return;
    }
    let (low, high) = items.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), item| {
        (low.min(item.centroid), high.max(item.centroid))
    });
    let axis = (high - low).max_position();
    let middle = clusters / 2 * CLUSTER_TRIANGLES;
    items.select_nth_unstable_by(middle, |a, b| a.centroid[axis].total_cmp(&b.centroid[axis]).then(a.id.cmp(&b.id)));
    let parallel = items.len() > PARALLEL_TRIANGLES;
    let (left, right) = items.split_at_mut(middle);
    if parallel {
        rayon::join(|| split(left), || split(right));
    } else {
        split(left);
        split(right);
    }
}

/// The cluster of these triangles, corners being indices into `positions`.
pub(super) fn bound(positions: &[[f32; 3]], triangles: &[[u32; 3]], first_index: u32) -> Cluster {
    let corners = || triangles.iter().flatten().map(|&i| Vec3::from(positions[i as usize]));
    let low = corners().fold(Vec3::INFINITY, Vec3::min);
    let high = corners().fold(Vec3::NEG_INFINITY, Vec3::max);
    let center = low * 0.5 + high * 0.5;
    let extent = reach(center, low.as_dvec3(), high.as_dvec3());
    Cluster { center: center.to_array(), first_index, extent, triangle_count: triangles.len() as u32 }
}

/// Half the edges of a box around `center` that contains both corners.
fn reach(center: Vec3, low: DVec3, high: DVec3) -> [f32; 3] {
    // the difference is exact in double precision but for huge ratios, so two steps up contain both ends
    let reach = (high - center.as_dvec3()).max(center.as_dvec3() - low).as_vec3();
    reach.to_array().map(|e| e.next_up().next_up())
}

/// Centre and half the edges of a box in mesh space that contains the boxes of all clusters of `mesh`, an entry of
/// [`Scene::meshes`].
pub fn mesh_bounds(scene: &Scene, mesh: &Mesh) -> ([f32; 3], [f32; 3]) {
    let clusters = scene.clusters.iter().skip(mesh.first_cluster as usize).take(mesh.cluster_count as usize);
    let boxes = clusters.map(|c| (Vec3::from(c.center).as_dvec3(), Vec3::from(c.extent).as_dvec3()));
    let (low, high) = boxes.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), (center, extent)| {
        (low.min(center - extent), high.max(center + extent))
    });
    let center = (low * 0.5 + high * 0.5).as_vec3();
    (center.to_array(), reach(center, low, high))
}
