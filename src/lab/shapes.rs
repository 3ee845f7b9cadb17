//! A bottom-level acceleration structure for each mesh, on devices with ray queries.

use super::LabError;
use super::device::LabDevice;
use crate::gpu::sync::{self, Access::*};
use crate::gpu::{Buffer, Gpu, Memory, Structure};
use crate::host::SceneBuffers;
use crate::scene::{Mesh, Scene};
use ash::vk;
use std::sync::Arc;

/// The structures and where their addresses lie.
pub(crate) struct Shapes {
    structures: Vec<Structure>,
    _addresses: Buffer,
    positions: u64,
    indices: u64,
    vertices: u32,
}

/// What the buffers of positions and indices need.
pub(crate) const USAGE: vk::BufferUsageFlags = vk::BufferUsageFlags::from_raw(
    vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS.as_raw()
        | vk::BufferUsageFlags::ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_KHR.as_raw(),
);

impl Shapes {
    /// Builds the structures of all meshes and gives their addresses to `buffers`.
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        device: &LabDevice,
        scene: &Scene,
        buffers: &mut SceneBuffers,
        [positions, indices]: [&Buffer; 2],
    ) -> Result<Self, LabError> {
        let (positions, indices, vertices) = (positions.address(), indices.address(), scene.positions.len() as u32);
        let made = |m: &Mesh| Structure::new(gpu, "mesh", &triangles(positions, indices, vertices), m.index_count / 3);
        let structures = scene.meshes.iter().map(made).collect::<Result<Vec<_>, _>>()?;
        let size = 8 * structures.len() as u64;
        let mut addresses = Buffer::new(gpu, "shapes", size, vk::BufferUsageFlags::STORAGE_BUFFER, Memory::Upload)?;
        for (to, structure) in addresses.bytes_mut().chunks_exact_mut(8).zip(&structures) {
            to.copy_from_slice(&structure.address().to_ne_bytes());
        }
        buffers.shapes = Some(addresses.raw);
        let shapes = Self { structures, _addresses: addresses, positions, indices, vertices };
        shapes.build(gpu, device, scene, 0..scene.meshes.len())?;
        Ok(shapes)
    }

    /// Builds those of some meshes and waits.
    pub(crate) fn build(
        &self,
        gpu: &Arc<Gpu>,
        device: &LabDevice,
        scene: &Scene,
        meshes: impl IntoIterator<Item = usize>,
    ) -> Result<(), LabError> {
        let cmd = device.begin()?;
        sync::barrier(&gpu.device, cmd, &[(TransferWrite, StructureBuild), (StructureRead, StructureBuild)]);
        for index in meshes {
            let mesh = &scene.meshes[index];
            let range = vk::AccelerationStructureBuildRangeInfoKHR::default()
                .primitive_count(mesh.index_count / 3)
                .primitive_offset(4 * mesh.first_index);
            self.structures[index].record(cmd, &triangles(self.positions, self.indices, self.vertices), range);
        }
        sync::barrier(&gpu.device, cmd, &[(StructureBuild, StructureBuild), (StructureBuild, StructureRead)]);
        device.submit_and_wait(cmd)?;
        Ok(())
    }
}

fn triangles(positions: u64, indices: u64, vertices: u32) -> vk::AccelerationStructureGeometryKHR<'static> {
    let address = |device_address| vk::DeviceOrHostAddressConstKHR { device_address };
    let triangles = vk::AccelerationStructureGeometryTrianglesDataKHR::default()
        .vertex_format(vk::Format::R32G32B32_SFLOAT)
        .vertex_data(address(positions))
        .vertex_stride(12)
        .max_vertex(vertices.saturating_sub(1))
        .index_type(vk::IndexType::UINT32)
        .index_data(address(indices));
    vk::AccelerationStructureGeometryKHR::default()
        .geometry_type(vk::GeometryTypeKHR::TRIANGLES)
        .geometry(vk::AccelerationStructureGeometryDataKHR { triangles })
}
