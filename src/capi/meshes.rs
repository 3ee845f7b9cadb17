//! Clusters of meshes, made on the CPU: what the scene's buffers hold.

use super::guard::{Failure, UmbrageResult, guard};
use super::input::{mutable, output, reference, slice};
use crate::{Cluster, Instance, Material, MeshBounds, Meshes};
use glam::{DAffine3, DMat3, DVec3};

/// How an instance casts; bits 0 and 1 of its flags.
pub type UmbrageCast = u32;
/// In the cached layer while it stands still, in the layer drawn every frame while it changes.
pub const UMBRAGE_CAST_AUTO: UmbrageCast = 0;
/// Always in the cached layer: each change redraws the pages it touches.
pub const UMBRAGE_CAST_STATIC: UmbrageCast = 1;
/// Always in the layer that is drawn every frame; its revision need not be kept.
pub const UMBRAGE_CAST_ALWAYS: UmbrageCast = 2;
/// Casts no shadow.
pub const UMBRAGE_CAST_NEVER: UmbrageCast = 3;
/// Bit of an instance's flags: its triangles are tested against alpha.
pub const UMBRAGE_CAST_ALPHA_TESTED: UmbrageCast = 4;
/// Bit of an instance's flags: the host draws it itself (host_draws). Its mesh is one cluster, of which only the bounds
/// matter (umbrage_meshes_add_bounds).
pub const UMBRAGE_CAST_HOST_DRAWN: UmbrageCast = 8;

/// The triangles of one mesh.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct UmbrageTriangles {
    /// Into the positions, three a triangle.
    pub indices: *const u32,
    /// Number of indices: a multiple of three, not 0.
    pub index_count: usize,
}

/// Meshes cut into clusters, on the CPU.
pub struct UmbrageMeshes(Meshes);

/// Contents of the scene's buffers of the same names; owned by the UmbrageMeshes that they come from.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct UmbrageMeshData {
    /// Three a triangle, absolute; the triangles of a mesh lie together, in another order than given.
    pub indices: *const u32,
    /// Number of indices.
    pub index_count: usize,
    /// Clusters, mesh by mesh.
    pub clusters: *const Cluster,
    /// Number of clusters.
    pub cluster_count: usize,
    /// Bounds and clusters of each mesh.
    pub meshes: *const MeshBounds,
    /// Number of meshes.
    pub mesh_count: usize,
    /// Vertex lists of the clusters.
    pub meshlets: *const u32,
    /// Number of words of these.
    pub meshlet_word_count: usize,
}

/// Cuts meshes into clusters. positions: of all vertices, mesh space. UMBRAGE_ERROR_LIMIT for a mesh without triangles,
/// an index beyond the positions and a position that is not finite. The pointers are not kept.
///
/// # Safety
/// Pointers to as many elements as their counts say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_meshes_create(
    positions: *const [f32; 3],
    position_count: usize,
    meshes: *const UmbrageTriangles,
    mesh_count: usize,
    made: *mut *mut UmbrageMeshes,
) -> UmbrageResult {
    guard(|| {
        // SAFETY: the caller vouches for the pointers
        let (positions, meshes, made) = unsafe {
            (
                slice(positions, position_count, "positions")?,
                slice(meshes, mesh_count, "meshes")?,
                output(made, "made")?,
            )
        };
        // SAFETY: as above
        let triangles = |mesh: &UmbrageTriangles| unsafe { slice(mesh.indices, mesh.index_count, "indices of a mesh") };
        let triangles = meshes.iter().map(triangles).collect::<Result<Vec<_>, _>>()?;
        let meshes = Meshes::new(positions, &triangles)?;
        made.write(Box::into_raw(Box::new(UmbrageMeshes(meshes))));
        Ok(())
    })
}

/// Adds a mesh that the host draws itself (UMBRAGE_CAST_HOST_DRAWN). low, high: corners of what it ever covers, displaced in
/// whatever way, in mesh space, three floats each. mesh: where its number goes. What umbrage_meshes_data gave before is no longer valid.
/// UMBRAGE_ERROR_LIMIT for corners that are not finite or not in this order.
///
/// # Safety
/// meshes: made and not destroyed. low, high: three floats each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_meshes_add_bounds(
    meshes: *mut UmbrageMeshes,
    low: *const f32,
    high: *const f32,
    mesh: *mut u32,
) -> UmbrageResult {
    guard(|| {
        // SAFETY: the caller vouches for the pointers
        let (UmbrageMeshes(meshes), low, high, mesh) = unsafe {
            (mutable(meshes, "meshes")?, slice(low, 3, "low")?, slice(high, 3, "high")?, output(mesh, "mesh")?)
        };
        mesh.write(meshes.add_bounds([low[0], low[1], low[2]], [high[0], high[1], high[2]])?);
        Ok(())
    })
}

/// Says where the data lie; valid until the meshes are changed or destroyed.
///
/// # Safety
/// meshes: made and not destroyed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_meshes_data(
    meshes: *const UmbrageMeshes,
    data: *mut UmbrageMeshData,
) -> UmbrageResult {
    guard(|| {
        // SAFETY: the caller vouches for the pointers
        let (UmbrageMeshes(meshes), data) = unsafe { (reference(meshes, "meshes")?, output(data, "data")?) };
        data.write(UmbrageMeshData {
            indices: meshes.indices.as_ptr(),
            index_count: meshes.indices.len(),
            clusters: meshes.clusters.as_ptr(),
            cluster_count: meshes.clusters.len(),
            meshes: meshes.meshes.as_ptr(),
            mesh_count: meshes.meshes.len(),
            meshlets: meshes.meshlets.as_ptr(),
            meshlet_word_count: meshes.meshlets.len(),
        });
        Ok(())
    })
}

/// Clusters of all these instances together: caster_count of UmbrageScene. UMBRAGE_ERROR_LIMIT for an instance of a
/// mesh that is not there, and for 2^32 clusters and more.
///
/// # Safety
/// meshes: made and not destroyed. instances: as many as instance_count says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_meshes_caster_count(
    meshes: *const UmbrageMeshes,
    instances: *const Instance,
    instance_count: usize,
    caster_count: *mut u32,
) -> UmbrageResult {
    guard(|| {
        // SAFETY: the caller vouches for the pointers
        let (UmbrageMeshes(meshes), instances, count) = unsafe {
            (
                reference(meshes, "meshes")?,
                slice(instances, instance_count, "instances")?,
                output(caster_count, "caster_count")?,
            )
        };
        let mut casters = 0u32;
        for instance in instances {
            let (mesh, known) = (instance.mesh, meshes.meshes.len());
            let Some(bounds) = meshes.meshes.get(mesh as usize) else {
                return Err(Failure::limit("mesh of an instance", mesh, format!("less than {known}")));
            };
            let more = casters.checked_add(bounds.cluster_count);
            casters = more.ok_or_else(|| Failure::limit("casters", "2^32 or more", "less than 2^32"))?;
        }
        count.write(casters);
        Ok(())
    })
}

/// Frees meshes; null is allowed.
///
/// # Safety
/// meshes: made and not destroyed, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_meshes_destroy(meshes: *mut UmbrageMeshes) {
    guard(|| {
        if !meshes.is_null() {
            // SAFETY: made by `umbrage_meshes_create`, and the caller gives it up
            drop(unsafe { Box::from_raw(meshes) });
        }
        Ok(())
    });
}

/// Makes an instance of policy auto. rows: of the affine matrix from mesh space to world space relative to the scene's
/// origin, double precision, of which the instance keeps about 48 bits of the translation.
///
/// # Safety
/// rows: three.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_instance_init(
    instance: *mut Instance,
    rows: *const [f64; 4],
    mesh: u32,
    material: u32,
) -> UmbrageResult {
    guard(|| {
        // SAFETY: the caller vouches for the pointers
        let (instance, rows) = unsafe { (output(instance, "instance")?, slice(rows, 3, "rows")?) };
        let column = |i: usize| DVec3::new(rows[0][i], rows[1][i], rows[2][i]);
        let matrix = DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) };
        instance.write(Instance::new(&matrix, mesh, material));
        Ok(())
    })
}

/// Makes a white, opaque material without a texture.
///
/// # Safety
/// material: room for one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_material_init(material: *mut Material) -> UmbrageResult {
    guard(|| {
        // SAFETY: the caller vouches for the pointer
        unsafe { output(material, "material")? }.write(Material::default());
        Ok(())
    })
}
