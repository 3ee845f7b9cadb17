//! Acceleration structures that free themselves, for devices with ray queries.

use super::{Buffer, Gpu, Memory};
use crate::error::{Context, Error};
use ash::vk;
use std::sync::Arc;

/// An acceleration structure with its memory and what building it needs.
pub(crate) struct Structure {
    pub(crate) raw: vk::AccelerationStructureKHR,
    kind: vk::AccelerationStructureTypeKHR,
    storage: Buffer,
    scratch: Buffer,
    gpu: Arc<Gpu>,
}

/// Instances at an address, in a structure over structures.
pub(crate) fn instances(address: u64) -> vk::AccelerationStructureGeometryKHR<'static> {
    let data = vk::DeviceOrHostAddressConstKHR { device_address: address };
    vk::AccelerationStructureGeometryKHR::default().geometry_type(vk::GeometryTypeKHR::INSTANCES).geometry(
        vk::AccelerationStructureGeometryDataKHR {
            instances: vk::AccelerationStructureGeometryInstancesDataKHR::default().data(data),
        },
    )
}

impl Structure {
    /// Room for `count` triangles or instances of a geometry.
    ///
    /// # Errors
    /// [`Error::Unsupported`] on a device without ray queries, and what [`Buffer::new`] reports.
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        name: &str,
        geometry: &vk::AccelerationStructureGeometryKHR<'_>,
        count: u32,
    ) -> Result<Self, Error> {
        let rays = gpu.ray_queries()?;
        // SAFETY: the geometry's kind says which part of the union is there
        let kind = match geometry.geometry_type {
            vk::GeometryTypeKHR::INSTANCES => vk::AccelerationStructureTypeKHR::TOP_LEVEL,
            _ => vk::AccelerationStructureTypeKHR::BOTTOM_LEVEL,
        };
        let geometries = [*geometry];
        let mut sizes = vk::AccelerationStructureBuildSizesInfoKHR::default();
        // SAFETY: sizes are asked for, addresses are not read
        unsafe {
            let device = vk::AccelerationStructureBuildTypeKHR::DEVICE;
            rays.functions.get_acceleration_structure_build_sizes(
                device,
                &build_info(kind, &geometries),
                &[count],
                &mut sizes,
            );
        }
        let usage = vk::BufferUsageFlags::ACCELERATION_STRUCTURE_STORAGE_KHR;
        let storage = Buffer::new(gpu, name, sizes.acceleration_structure_size, usage, Memory::Device)?;
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS;
        let room = sizes.build_scratch_size + rays.scratch_alignment;
        let scratch = Buffer::new(gpu, "structure scratch", room, usage, Memory::Device)?;
        let info = vk::AccelerationStructureCreateInfoKHR::default()
            .buffer(storage.raw)
            .size(sizes.acceleration_structure_size)
            .ty(kind);
        // SAFETY: the buffer is as large as the device asked for
        let raw = unsafe { rays.functions.create_acceleration_structure(&info, None) }
            .context("vkCreateAccelerationStructureKHR")?;
        gpu.name(raw, name);
        Ok(Self { raw, kind, storage, scratch, gpu: gpu.clone() })
    }

    /// Device memory in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        self.storage.size + self.scratch.size
    }

    /// Where other structures find it.
    #[cfg_attr(not(feature = "lab"), allow(dead_code))] // the lab makes structures of meshes
    pub(crate) fn address(&self) -> u64 {
        let info = vk::AccelerationStructureDeviceAddressInfoKHR::default().acceleration_structure(self.raw);
        // SAFETY: the structure is alive; without ray queries there is none
        self.gpu.rays.as_ref().map_or(0, |r| unsafe { r.functions.get_acceleration_structure_device_address(&info) })
    }

    /// Builds it anew from as many triangles or instances as it has room for, or fewer.
    pub(crate) fn record(
        &self,
        cmd: vk::CommandBuffer,
        geometry: &vk::AccelerationStructureGeometryKHR<'_>,
        range: vk::AccelerationStructureBuildRangeInfoKHR,
    ) {
        let Some(rays) = &self.gpu.rays else { return };
        let scratch = self.scratch.address().next_multiple_of(rays.scratch_alignment);
        let geometries = [*geometry];
        let mut info = build_info(self.kind, &geometries).dst_acceleration_structure(self.raw);
        info.scratch_data = vk::DeviceOrHostAddressKHR { device_address: scratch };
        // SAFETY: the command buffer is recording; the callers' addresses are those of buffers that hold the range
        unsafe { rays.functions.cmd_build_acceleration_structures(cmd, &[info], &[&[range]]) };
    }
}

fn build_info<'a>(
    kind: vk::AccelerationStructureTypeKHR,
    geometries: &'a [vk::AccelerationStructureGeometryKHR<'a>],
) -> vk::AccelerationStructureBuildGeometryInfoKHR<'a> {
    vk::AccelerationStructureBuildGeometryInfoKHR::default()
        .ty(kind)
        .flags(vk::BuildAccelerationStructureFlagsKHR::PREFER_FAST_TRACE)
        .mode(vk::BuildAccelerationStructureModeKHR::BUILD)
        .geometries(geometries)
}

impl Drop for Structure {
    fn drop(&mut self) {
        if let Some(rays) = &self.gpu.rays {
            // SAFETY: the owner waits for the GPU before dropping resources
            unsafe { rays.functions.destroy_acceleration_structure(self.raw, None) };
        }
    }
}
