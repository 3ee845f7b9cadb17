//! What casts: the structs that the buffers of [`crate::host::SceneBuffers`] hold, and clusters of meshes made from plain
//! triangles on the CPU, once for each mesh.

use crate::Error;
pub use crate::gpu::structs::MeshBounds;
use bytemuck::{Pod, Zeroable};
use glam::{DAffine3, DVec3, Vec3};

/// Most triangles a cluster may hold.
pub const CLUSTER_TRIANGLES: usize = 128;
/// Marks "no texture" in [`Material::texel_offset`].
pub const NO_TEXTURE: u32 = u32::MAX;

/// Per-vertex data that only alpha tests and shading need; parallel to the positions.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Attributes {
    /// Texture coordinate of the base colour (the set the material names), before the texture transform.
    pub uv: [f32; 2],
    /// Vertex colour, linear RGBA, 8 bits each, R in the lowest byte; white where the file has none.
    pub color: u32,
}

/// At most [`CLUSTER_TRIANGLES`] neighbouring triangles of one mesh with their bounds in mesh space.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Cluster {
    /// Centre of the axis-aligned bounds, mesh space.
    pub center: [f32; 3],
    /// First entry in the indices.
    pub first_index: u32,
    /// Half the size of the bounds, mesh space.
    pub extent: [f32; 3],
    /// Number of triangles, 1 to [`CLUSTER_TRIANGLES`]; 0 where the host draws them.
    pub triangle_count: u32,
}

/// One placement of a mesh.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Instance {
    /// Rows of the affine 3x4 matrix from mesh space to world space relative to the scene's origin.
    pub rows: [[f32; 4]; 3],
    /// What single precision leaves of the translation, to be added to the rows' last column; w is 0. Zero throughout is
    /// allowed: then the instance stands where its rows say.
    pub low: [f32; 4],
    /// Entry in the materials.
    pub material: u32,
    /// Entry in the meshes.
    pub mesh: u32,
    /// Any change of this number tells the engine that the instance moved or deformed or that its alpha changed.
    pub revision: u32,
    /// How the instance casts, a [`CastPolicy`]; bit 2: its mesh is alpha tested
    /// ([`ALPHA_TESTED`]); bit 3: the host draws it ([`HOST_DRAWN`]).
    pub flags: u32,
}

impl Instance {
    /// A caster of policy auto. `matrix`: world space relative to the scene's origin from mesh space.
    pub fn new(matrix: &DAffine3, mesh: u32, material: u32) -> Self {
        let rows = std::array::from_fn(|i| matrix.matrix3.row(i).extend(0.0).as_vec4().to_array());
        let mut instance = Self { rows, mesh, material, ..Self::zeroed() };
        instance.set_translation(matrix.translation);
        instance
    }

    /// With another policy.
    pub fn with_policy(self, policy: CastPolicy) -> Self {
        Self { flags: self.flags & !3 | policy as u32, ..self }
    }

    /// Drawn by the host ([`HOST_DRAWN`]).
    pub fn host_drawn(self) -> Self {
        Self { flags: self.flags | HOST_DRAWN, ..self }
    }

    /// The translation, world space relative to the scene's origin.
    pub fn translation(&self) -> DVec3 {
        DVec3::from_array([0, 1, 2].map(|i| f64::from(self.rows[i][3]) + f64::from(self.low[i])))
    }

    /// Sets the translation, to about 48 bits.
    pub fn set_translation(&mut self, translation: DVec3) {
        for (i, (high, low)) in split(translation).into_iter().enumerate() {
            (self.rows[i][3], self.low[i]) = (high, low);
        }
    }
}

/// Each coordinate in single precision and what that leaves.
pub(crate) fn split(v: DVec3) -> [(f32, f32); 3] {
    v.to_array().map(|v| (v as f32, (v - f64::from(v as f32)) as f32))
}

/// Base colour and alpha of a surface.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Material {
    /// Linear RGBA factor.
    pub base_color: [f32; 4],
    /// First row of the texture transform: u' = x*u + y*v + z.
    pub uv_row0: [f32; 4],
    /// Second row: v' = x*u + y*v + z.
    pub uv_row1: [f32; 4],
    /// First texel in the texels, or [`NO_TEXTURE`].
    pub texel_offset: u32,
    /// Texture width in texels.
    pub width: u32,
    /// Texture height in texels.
    pub height: u32,
    /// Wrap modes: bits 0-1 for u, bits 2-3 for v; 0 repeat, 1 mirrored repeat, 2 clamp to edge.
    pub wrap: u32,
    /// A point is cut away where alpha < cutoff; 0 for opaque materials, 0.5 for BLEND.
    pub alpha_cutoff: f32,
    /// 1: the surface holds back the share `alpha` of the light, where a method can tell; others test it against the cutoff. 0: it
    /// holds back all.
    pub translucent: u32,
    /// Zero.
    pub pad: [u32; 2],
}

impl Material {
    /// White without a texture, opaque.
    pub const WHITE: Self = Self {
        base_color: [1.0; 4],
        uv_row0: [1.0, 0.0, 0.0, 0.0],
        uv_row1: [0.0, 1.0, 0.0, 0.0],
        texel_offset: NO_TEXTURE,
        width: 0,
        height: 0,
        wrap: 0,
        alpha_cutoff: 0.0,
        translucent: 0,
        pad: [0; 2],
    };
}

impl Default for Material {
    fn default() -> Self {
        Self::WHITE
    }
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
/// Bit of an instance's `flags`: the host draws it itself ([`crate::SceneBuffers::host_draws`]). Its mesh is one cluster, of
/// which only the bounds matter ([`Meshes::add_bounds`]).
pub const HOST_DRAWN: u32 = 8;

/// What the engine draws of a list of meshes, on the CPU: contents of [`crate::host::SceneBuffers`] of the same names.
#[derive(Debug, Clone, Default)]
pub struct Meshes {
    /// Three a triangle, absolute; the triangles of a mesh lie together, in another order than given.
    pub indices: Vec<u32>,
    /// Clusters, mesh by mesh.
    pub clusters: Vec<Cluster>,
    /// Bounds and clusters of each mesh.
    pub meshes: Vec<MeshBounds>,
    /// Vertex lists of the clusters.
    pub meshlets: Vec<u32>,
}

impl Meshes {
    /// Cuts meshes into clusters. `positions`: of all vertices, mesh space; `meshes`: the triangles of each, indices into
    /// the positions.
    ///
    /// # Errors
    /// [`Error::Limit`] for a mesh without triangles or with a number of indices that is no multiple of three, an index
    /// beyond the positions, a position that is not finite, and more than 2^32 indices.
    pub fn new(positions: &[[f32; 3]], meshes: &[&[u32]]) -> Result<Self, Error> {
        let refused = |field, given: String, limit: String| Err(Error::Limit { field, given, limit });
        let mut made = Self::default();
        for (number, &indices) in meshes.iter().enumerate() {
            if indices.is_empty() || !indices.len().is_multiple_of(3) {
                let given = format!("{} in mesh {number}", indices.len());
                return refused("indices", given, "three a triangle, at least one triangle".into());
            }
            if let Some(index) = indices.iter().find(|&&i| i as usize >= positions.len()) {
                let given = format!("{index} in mesh {number}");
                return refused("index", given, format!("less than the number of vertices, {}", positions.len()));
            }
            if let Some(p) = indices.iter().map(|&i| positions[i as usize]).find(|p| !p.iter().all(|v| v.is_finite())) {
                return refused("position", format!("{p:?} in mesh {number}"), "finite".into());
            }
            let mut triangles: Vec<[u32; 3]> = indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
            let clusters = build(positions, &mut triangles);
            let first_index = u32::try_from(made.indices.len() + indices.len()).map(|end| end - indices.len() as u32);
            let Ok(first_index) = first_index else {
                return refused("indices", format!("more than 2^32 with mesh {number}"), "less than 2^32".into());
            };
            let (center, extent) = bounds_of(&clusters);
            let (first_cluster, cluster_count) = (made.clusters.len() as u32, clusters.len() as u32);
            made.meshes.push(MeshBounds { center, first_cluster, extent, cluster_count });
            made.clusters.extend(clusters.iter().map(|c| Cluster { first_index: first_index + c.first_index, ..*c }));
            made.indices.extend(triangles.as_flattened());
        }
        made.meshlets = meshlets(&made.indices, &made.clusters, positions.len());
        Ok(made)
    }

    /// Adds a mesh that the host draws itself ([`HOST_DRAWN`]) and returns its number. `low`, `high`: corners of what it ever
    /// covers, displaced in whatever way, in mesh space.
    ///
    /// # Errors
    /// [`Error::Limit`] for corners that are not finite or not in this order.
    pub fn add_bounds(&mut self, low: [f32; 3], high: [f32; 3]) -> Result<u32, Error> {
        crate::host::check_bounds(low.map(f64::from), high.map(f64::from))?;
        let cluster = bound(&[low, high], &[[0, 1, 1]], 0);
        let (first_cluster, mesh) = (self.clusters.len() as u32, self.meshes.len() as u32);
        // the words of meshlets begin with one for each cluster that has any
        self.clusters.push(Cluster { triangle_count: 0, ..cluster });
        let Cluster { center, extent, .. } = cluster;
        self.meshes.push(MeshBounds { center, first_cluster, extent, cluster_count: 1 });
        Ok(mesh)
    }

    /// Number of casters of a list of instances, given the mesh of each: [`crate::host::SceneBuffers::caster_count`].
    ///
    /// # Panics
    /// When there is no such mesh.
    pub fn caster_count(&self, instances: impl IntoIterator<Item = u32>) -> u32 {
        instances.into_iter().map(|mesh| self.meshes[mesh as usize].cluster_count).sum()
    }
}

/// Triangle counts above which both halves of a split are worth two threads.
const PARALLEL_TRIANGLES: usize = 1 << 14;

/// Reorders the triangles and returns the clusters that tile them, `first_index` counted from the first triangle.
///
/// All clusters but the last are full: each split is at the median of the longest axis of the centroids, rounded to
/// a multiple of [`CLUSTER_TRIANGLES`]. The result depends on the input alone, not on the number of threads.
pub(crate) fn build(positions: &[[f32; 3]], triangles: &mut [[u32; 3]]) -> Vec<Cluster> {
    let corner = |i: u32| Vec3::from(positions[i as usize]);
    // halves before the sum: corners near the largest float must not overflow
    let centroid = |t: &[u32; 3]| t.iter().map(|&i| corner(i) / 3.0).sum();
    let mut items: Vec<Item> =
        triangles.iter().zip(0..).map(|(t, id)| Item { centroid: centroid(t), id, corners: *t }).collect();
    halve(&mut items);
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

fn halve(items: &mut [Item]) {
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
        join(|| halve(left), || halve(right));
    } else {
        halve(left);
        halve(right);
    }
}

/// The cluster of these triangles, corners being indices into `positions`.
pub(crate) fn bound(positions: &[[f32; 3]], triangles: &[[u32; 3]], first_index: u32) -> Cluster {
    let corners = || triangles.iter().flatten().map(|&i| Vec3::from(positions[i as usize]));
    let low = corners().fold(Vec3::INFINITY, Vec3::min);
    let high = corners().fold(Vec3::NEG_INFINITY, Vec3::max);
    let center = low * 0.5 + high * 0.5;
    let extent = reach(center, low.as_dvec3(), high.as_dvec3());
    Cluster { center: center.to_array(), first_index, extent, triangle_count: triangles.len() as u32 }
}

/// Half the edges of a box around `center` that contains both corners.
pub(crate) fn reach(center: Vec3, low: DVec3, high: DVec3) -> [f32; 3] {
    // the difference is exact in double precision but for huge ratios, so two steps up contain both ends
    let reach = (high - center.as_dvec3()).max(center.as_dvec3() - low).as_vec3();
    reach.to_array().map(|e| e.next_up().next_up())
}

/// Runs both, at the same time where the program has threads for it.
fn join(a: impl FnOnce() + Send, b: impl FnOnce() + Send) {
    #[cfg(feature = "lab")]
    rayon::join(a, b);
    #[cfg(not(feature = "lab"))]
    {
        a();
        b();
    }
}

/// Centre and half the edges of a box that contains the boxes of all clusters.
pub(crate) fn bounds_of(clusters: &[Cluster]) -> ([f32; 3], [f32; 3]) {
    let boxes = clusters.iter().map(|c| (Vec3::from(c.center).as_dvec3(), Vec3::from(c.extent).as_dvec3()));
    let (low, high) = boxes.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), (center, extent)| {
        (low.min(center - extent), high.max(center + extent))
    });
    let center = (low * 0.5 + high * 0.5).as_vec3();
    (center.to_array(), reach(center, low, high))
}

/// For each cluster the word where its meshlet begins; then the meshlets: number of distinct vertices, these vertices,
/// then one word a triangle with three 10-bit positions in that list.
pub(crate) fn meshlets(indices: &[u32], clusters: &[Cluster], vertex_count: usize) -> Vec<u32> {
    let mut words = vec![0; clusters.len()];
    // position of a vertex in the list of the cluster that touched it last
    let mut local = vec![(u32::MAX, 0u32); vertex_count];
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    for (c, cluster) in clusters.iter().enumerate() {
        vertices.clear();
        triangles.clear();
        let first = cluster.first_index as usize;
        for corners in indices[first..first + 3 * cluster.triangle_count as usize].chunks_exact(3) {
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
