//! What ray queries go through: the casters of a frame over the host's structures of their meshes, relative to the eye of a
//! view. Instead of the tree of [`super::bvh`] where the device has ray queries.
//!
//! Reads: frame constants, instances, addresses of the meshes' structures. Writes: the structure. It has room for every
//! instance.

use super::exact;
use crate::gpu::sync::{self, Access};
use crate::gpu::{self, Binding, Buffer, Compute, Gpu, Memory, Structure, spirv};
use crate::host::SceneBuffers;
use crate::{Config, Error};
use ash::vk;
use std::sync::Arc;

/// Most instances: their number is the custom index of 24 bits.
const MOST: u32 = 1 << 24;
/// Bytes of a `VkAccelerationStructureInstanceKHR`.
const RECORD: u64 = size_of::<vk::AccelerationStructureInstanceKHR>() as u64;

pub(crate) struct RayQuery {
    structure: Structure,
    records: Buffer,
    instances: Compute,
    count: u32,
}

/// Whether rays are traced by ray queries; else they walk through the tree.
pub(crate) fn chosen(gpu: &Gpu, config: &Config, scene: &SceneBuffers) -> bool {
    config.exact && config.ray_query && gpu.rays.is_some() && scene.shapes.is_some()
}

impl RayQuery {
    /// `frame`: constants of the view; `shapes`: [`SceneBuffers::shapes`].
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        scene: &SceneBuffers,
        shapes: vk::Buffer,
        frame: Binding<'_>,
    ) -> Result<Self, Error> {
        let count = scene.instance_count;
        if count > MOST {
            let limit = format!("at most {MOST} with ray queries");
            return Err(Error::Limit { field: "instance_count", given: count.to_string(), limit });
        }
        use vk::BufferUsageFlags as U;
        let usage = U::STORAGE_BUFFER | U::SHADER_DEVICE_ADDRESS | U::ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_KHR;
        let records = Buffer::new(gpu, "ray instances", RECORD * u64::from(count), usage, Memory::Device)?;
        let structure = Structure::new(gpu, "casters of rays", &gpu::instances(0), count)?;
        let bindings =
            [frame, Binding::External(scene.instances), Binding::External(shapes), Binding::Storage(&records)];
        let words = spirv!("engine/query_instances.comp");
        let instances = Compute::new(gpu, "query_instances", words, &bindings, &[count], 0)?;
        Ok(Self { structure, records, instances, count })
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.structure.bytes() + self.records.size
    }

    /// Places the instances of all views and builds the structures; the caller has ordered writes of constants and scene
    /// before compute reads. Ray queries in compute shaders may follow.
    pub(crate) fn record<'a>(
        device: &ash::Device,
        cmd: vk::CommandBuffer,
        queries: impl Iterator<Item = &'a Self> + Clone,
    ) {
        use Access::*;
        sync::barrier(device, cmd, &[(StructureBuild, ComputeWrite)]);
        for query in queries.clone() {
            query.instances.dispatch(cmd, &(), [query.count.div_ceil(64), 1, 1]);
        }
        sync::barrier(
            device,
            cmd,
            &[(ComputeWrite, StructureBuild), (StructureRead, StructureBuild), (StructureBuild, StructureBuild)],
        );
        for query in queries {
            let range = vk::AccelerationStructureBuildRangeInfoKHR::default().primitive_count(query.count);
            query.structure.record(cmd, &gpu::instances(query.records.address()), range);
        }
        sync::barrier(device, cmd, &[(StructureBuild, StructureRead)]);
    }

    /// What `exact_query` binds from its `RAY_BINDING` on.
    pub(crate) fn bindings<'a>(&'a self, scene: &SceneBuffers) -> Vec<Binding<'a>> {
        let more = [scene.meshes, scene.clusters, scene.indices].map(Binding::External);
        [[Binding::Structure(&self.structure)].as_slice(), &exact::hit_bindings(scene), &more].concat()
    }
}
