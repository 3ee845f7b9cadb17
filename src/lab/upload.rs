//! Brings a scene to the device.

use super::LabError;
use super::device::LabDevice;
use crate::gpu::structs::Caster;
use crate::gpu::sync::{self, Access};
use crate::gpu::{Buffer, Gpu, Memory};
use crate::host::SceneBuffers;
use crate::scene::Scene;
use ash::vk;
use std::sync::Arc;

/// Bytes of the staging buffer.
const STAGING: usize = 16 << 20;
/// Room behind the scene's indices for compacted ones; the default of `Config::index_capacity`.
pub(crate) const INDEX_ROOM: u64 = 6 << 20;

/// The clusters that cast, opaque ones first, and where the alpha-tested ones begin.
fn casters(scene: &Scene) -> (Vec<Caster>, u32) {
    let mut casters = Vec::new();
    let mut first_masked = 0;
    for masked in [false, true] {
        first_masked = if masked { casters.len() as u32 } else { 0 };
        for mesh in scene.meshes.iter().filter(|m| m.casts && m.alpha_tested == masked) {
            for instance in mesh.first_instance..mesh.first_instance + mesh.instance_count {
                casters.extend(
                    (mesh.first_cluster..mesh.first_cluster + mesh.cluster_count)
                        .map(|cluster| Caster { instance, cluster }),
                );
            }
        }
    }
    (casters, first_masked)
}

/// Uploads everything and waits.
pub(crate) fn scene(
    gpu: &Arc<Gpu>,
    device: &LabDevice,
    scene: &Scene,
) -> Result<(SceneBuffers, Vec<Buffer>), LabError> {
    use vk::BufferUsageFlags as U;
    let (casters, first_masked) = casters(scene);
    let meshlets = super::meshlets::pack(scene);
    let sources: [(&str, &[u8], U, u64); 9] = [
        ("positions", bytemuck::cast_slice(&scene.positions), U::VERTEX_BUFFER, 0),
        ("attributes", bytemuck::cast_slice(&scene.attributes), U::VERTEX_BUFFER, 0),
        ("indices", bytemuck::cast_slice(&scene.indices), U::INDEX_BUFFER, 4 * INDEX_ROOM),
        ("clusters", bytemuck::cast_slice(&scene.clusters), U::empty(), 0),
        ("instances", bytemuck::cast_slice(&scene.instances), U::empty(), 0),
        ("materials", bytemuck::cast_slice(&scene.materials), U::empty(), 0),
        ("texels", bytemuck::cast_slice(&scene.texels), U::empty(), 0),
        ("casters", bytemuck::cast_slice(&casters), U::empty(), 0),
        ("meshlets", bytemuck::cast_slice(&meshlets), U::empty(), 0),
    ];
    let mut staging = Buffer::new(gpu, "staging", STAGING as u64, U::TRANSFER_SRC, Memory::Upload)?;
    let mut buffers = Vec::new();
    for (name, bytes, usage, room) in sources {
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
    let raw = |i: usize| buffers[i].raw;
    let view = SceneBuffers {
        positions: raw(0),
        attributes: raw(1),
        indices: raw(2),
        index_count: scene.indices.len() as u32,
        clusters: raw(3),
        instances: raw(4),
        materials: raw(5),
        texels: raw(6),
        casters: raw(7),
        meshlets: raw(8),
        caster_count: casters.len() as u32,
        first_masked,
        bounds_min: (scene.bounds_min - scene.origin).to_array(),
        bounds_max: (scene.bounds_max - scene.origin).to_array(),
    };
    Ok((view, buffers))
}
