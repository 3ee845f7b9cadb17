//! Brings a scene to the device.

use super::LabError;
use super::device::LabDevice;
use crate::casters;
use crate::gpu::structs::MeshBounds;
use crate::gpu::sync::{self, Access};
use crate::gpu::{Buffer, Gpu, Memory};
use crate::host::{PositionLayout, SceneBuffers};
use crate::scene::{Changes, Mesh, Scene, mesh_bounds};
use ash::vk;
use std::ops::Range;
use std::sync::Arc;

/// Bytes of the staging buffer.
const STAGING: usize = 16 << 20;
/// Room behind the scene's indices for compacted ones; the default of `Config::index_capacity`.
pub(crate) const INDEX_ROOM: u64 = 6 << 20;

/// Bounds and clusters of every mesh.
fn mesh_list(scene: &Scene) -> Vec<MeshBounds> {
    let bounds = |mesh: &Mesh| {
        let (center, extent) = mesh_bounds(scene, mesh);
        MeshBounds { center, first_cluster: mesh.first_cluster, extent, cluster_count: mesh.cluster_count }
    };
    scene.meshes.iter().map(bounds).collect()
}

/// Uploads everything and waits.
pub(crate) fn scene(
    gpu: &Arc<Gpu>,
    device: &LabDevice,
    scene: &Scene,
) -> Result<(SceneBuffers, Vec<Buffer>), LabError> {
    use vk::BufferUsageFlags as U;
    let shape = if gpu.rays.is_some() { super::shapes::USAGE } else { U::empty() };
    let meshes = mesh_list(scene);
    let meshlets = casters::meshlets(&scene.indices, &scene.clusters, scene.positions.len());
    let sources: [Source<'_>; 9] = [
        ("positions", bytemuck::cast_slice(&scene.positions), U::VERTEX_BUFFER | shape, 0),
        ("attributes", bytemuck::cast_slice(&scene.attributes), U::VERTEX_BUFFER, 0),
        ("indices", bytemuck::cast_slice(&scene.indices), U::INDEX_BUFFER | shape, 4 * INDEX_ROOM),
        ("clusters", bytemuck::cast_slice(&scene.clusters), U::empty(), 0),
        ("instances", bytemuck::cast_slice(&scene.instances), U::empty(), 0),
        ("materials", bytemuck::cast_slice(&scene.materials), U::empty(), 0),
        ("texels", bytemuck::cast_slice(&scene.texels), U::empty(), 0),
        ("meshes", bytemuck::cast_slice(&meshes), U::empty(), 0),
        ("meshlets", bytemuck::cast_slice(&meshlets), U::empty(), 0),
    ];
    let buffers = storage(gpu, device, &sources)?;
    let raw = |i: usize| buffers[i].raw;
    let view = SceneBuffers {
        positions: raw(0),
        position_layout: PositionLayout::PACKED,
        attributes: Some(raw(1)),
        indices: raw(2),
        index_count: scene.indices.len() as u32,
        clusters: raw(3),
        instances: raw(4),
        materials: raw(5),
        texels: raw(6),
        meshes: raw(7),
        meshlets: raw(8),
        shapes: None,
        host_draws: None,
        instance_count: scene.instances.len() as u32,
        caster_count: scene.meshes.iter().map(|m| m.instance_count * m.cluster_count).sum(),
        alpha_tested: scene.meshes.iter().any(|m| m.alpha_tested),
        bounds_min: (scene.bounds_min - scene.origin).to_array(),
        bounds_max: (scene.bounds_max - scene.origin).to_array(),
    };
    Ok((view, buffers))
}

/// A name, what a buffer holds, its usage beyond that of storage, and bytes of room behind that.
pub(crate) type Source<'a> = (&'a str, &'a [u8], vk::BufferUsageFlags, u64);

/// Makes and fills storage buffers and waits.
pub(crate) fn storage(gpu: &Arc<Gpu>, device: &LabDevice, sources: &[Source<'_>]) -> Result<Vec<Buffer>, LabError> {
    let mut staging = Buffer::new(gpu, "staging", STAGING as u64, vk::BufferUsageFlags::TRANSFER_SRC, Memory::Upload)?;
    let mut buffers = Vec::new();
    for &(name, bytes, usage, room) in sources {
        let buffer = Buffer::storage(gpu, name, bytes.len() as u64 + room, usage)?;
        for (i, chunk) in bytes.chunks(STAGING).enumerate() {
            staging.bytes_mut()[..chunk.len()].copy_from_slice(chunk);
            let cmd = device.begin()?;
            let copy = [vk::BufferCopy { src_offset: 0, dst_offset: (i * STAGING) as u64, size: chunk.len() as u64 }];
            sync::barrier(&gpu.device, cmd, &[(Access::HostWrite, Access::TransferRead)]);
            // SAFETY: the chunk fits both buffers
            unsafe { gpu.device.cmd_copy_buffer(cmd, staging.raw, buffer.raw, &copy) };
            device.submit_and_wait(cmd)?;
        }
        buffers.push(buffer);
    }
    Ok(buffers)
}

/// Uploads what a pose changed and waits.
pub(crate) fn changes(
    gpu: &Arc<Gpu>,
    device: &LabDevice,
    scene: &Scene,
    buffers: &SceneBuffers,
    changes: &Changes,
) -> Result<(), LabError> {
    let instances: Vec<Range<u32>> =
        changes.instances.chunk_by(|a, b| a + 1 == *b).map(|c| c[0]..c[0] + c.len() as u32).collect();
    let mut copies = Vec::new();
    runs(&mut copies, buffers.positions, &scene.positions, &changes.vertices);
    runs(&mut copies, buffers.clusters, &scene.clusters, &changes.clusters);
    runs(&mut copies, buffers.instances, &scene.instances, &instances);
    let meshes = if changes.meshes.is_empty() { Vec::new() } else { mesh_list(scene) };
    let deformed: Vec<Range<u32>> = changes.meshes.iter().map(|&m| m..m + 1).collect();
    runs(&mut copies, buffers.meshes, &meshes, &deformed);
    let total: usize = copies.iter().map(|c| c.bytes.len()).sum();
    let room = total.clamp(1, STAGING);
    let mut staging = Buffer::new(gpu, "staging", room as u64, vk::BufferUsageFlags::TRANSFER_SRC, Memory::Upload)?;
    let mut rest = &copies[..];
    while !rest.is_empty() {
        let mut used = 0;
        let fitting = rest.iter().take_while(|c| {
            used += c.bytes.len();
            used <= room
        });
        let (batch, later) = rest.split_at(fitting.count());
        submit(gpu, device, &mut staging, batch)?;
        rest = later;
    }
    Ok(())
}

/// Bytes that go to a place in a buffer.
struct Copy<'a> {
    buffer: vk::Buffer,
    at: u64,
    bytes: &'a [u8],
}

/// Adds the copies that bring runs of `list` to its buffer, none larger than the staging buffer may be.
fn runs<'a, T: bytemuck::Pod>(copies: &mut Vec<Copy<'a>>, buffer: vk::Buffer, list: &'a [T], runs: &[Range<u32>]) {
    for run in runs {
        let first = run.start as usize * size_of::<T>();
        let bytes: &[u8] = bytemuck::cast_slice(&list[run.start as usize..run.end as usize]);
        let chunks = bytes.chunks(STAGING).enumerate();
        copies.extend(chunks.map(|(i, bytes)| Copy { buffer, at: (first + i * STAGING) as u64, bytes }));
    }
}

/// Copies what fits the staging buffer together and waits.
fn submit(gpu: &Arc<Gpu>, device: &LabDevice, staging: &mut Buffer, copies: &[Copy]) -> Result<(), LabError> {
    use Access::*;
    let cmd = device.begin()?;
    sync::barrier(
        &gpu.device,
        cmd,
        &[(HostWrite, TransferRead), (ComputeRead, TransferWrite), (GraphicsRead, TransferWrite)],
    );
    let mut from = 0;
    for copy in copies {
        staging.bytes_mut()[from..][..copy.bytes.len()].copy_from_slice(copy.bytes);
        let size = copy.bytes.len() as u64;
        let region = [vk::BufferCopy { src_offset: from as u64, dst_offset: copy.at, size }];
        // SAFETY: the batch fits the staging buffer; a run lies within its list and so within the list's buffer
        unsafe { gpu.device.cmd_copy_buffer(cmd, staging.raw, copy.buffer, &region) };
        from += copy.bytes.len();
    }
    sync::barrier(&gpu.device, cmd, &[(TransferWrite, ComputeRead), (TransferWrite, GraphicsRead)]);
    device.submit_and_wait(cmd)?;
    Ok(())
}
