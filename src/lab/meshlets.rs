//! Clusters with their own short vertex lists, so that culling transforms each vertex once.

use crate::scene::Scene;

/// For each cluster the word where its meshlet begins; then the meshlets: number of distinct vertices, these vertices,
/// then one word a triangle with three 10-bit positions in that list.
pub(crate) fn pack(scene: &Scene) -> Vec<u32> {
    let mut words = vec![0; scene.clusters.len()];
    // position of a vertex in the list of the cluster that touched it last
    let mut local = vec![(u32::MAX, 0u32); scene.positions.len()];
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    for (c, cluster) in scene.clusters.iter().enumerate() {
        vertices.clear();
        triangles.clear();
        let first = cluster.first_index as usize;
        for corners in scene.indices[first..first + 3 * cluster.triangle_count as usize].chunks_exact(3) {
            let mut word = 0;
            for (i, &vertex) in corners.iter().enumerate() {
                let known = &mut local[vertex as usize];
                if known.0 != c as u32 {
                    *known = (c as u32, vertices.len() as u32);
                    vertices.push(vertex);
                }
                word |= known.1 << (10 * i);
            }
            triangles.push(word);
        }
        words[c] = words.len() as u32;
        words.push(vertices.len() as u32);
        words.extend(&vertices);
        words.extend(&triangles);
    }
    words
}
