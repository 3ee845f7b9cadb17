//! Rays of listed items through the tree of [`super::bvh`]: what the shadow map cannot decide, decided by the casters.
//! Reads: number of items, rays, frame constants, the tree, the scene. Writes: visibility, a word an item: 1 lit, 0 shadowed.
//! At capacity: the rest is not traced.

use super::bvh::Bvh;
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Buffer, Compute, Gpu, Image, spirv};
use crate::{Config, Error};
use ash::vk;
use std::sync::Arc;

/// Origin and direction of a ray.
pub(crate) const RAY_BYTES: u32 = 32;

pub(crate) struct Exact {
    /// Number of items: a word.
    pub(crate) count: Buffer,
    /// Two `vec4` an item: receiver relative to the eye and `t_max`, direction and packed normal.
    pub(crate) rays: Buffer,
    pub(crate) visibility: Buffer,
    /// Pixel and light of each, and how many are of the same pixel.
    pub(crate) items: Buffer,
    arguments: Buffer,
    prepare: Compute,
    trace: Compute,
    resolve: Option<Compute>,
    pub(crate) capacity: u32,
    device: ash::Device,
}

impl Exact {
    /// `frame`: constants of the view; `mask`: where the lookup left zeros for the items.
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        config: &Config,
        bvh: &Bvh,
        capacity: u32,
        frame: Binding<'_>,
        mask: Option<&Image>,
    ) -> Result<Self, Error> {
        let many = u64::from(capacity);
        let none = vk::BufferUsageFlags::empty();
        let count = Buffer::storage(gpu, "exact items", 4, none)?;
        let rays = Buffer::storage(gpu, "exact rays", u64::from(RAY_BYTES) * many, none)?;
        let visibility = Buffer::storage(gpu, "exact visibility", 4 * many, none)?;
        let items = Buffer::storage(gpu, "exact pixels", 8 * many, none)?;
        let arguments = Buffer::storage(gpu, "exact dispatch", 12, vk::BufferUsageFlags::INDIRECT_BUFFER)?;
        let [c, r, v, a] = [&count, &rays, &visibility, &arguments].map(Binding::Storage);
        let bindings = [&[c, r, v, frame], bvh.ray_bindings().as_slice()].concat();
        let constants = bvh.ray_constants(config);
        Ok(Self {
            prepare: Compute::new(gpu, "exact_prepare", spirv!("engine/exact_prepare.comp"), &[c, a], &[], 4)?,
            trace: Compute::new(gpu, "exact_trace", spirv!("engine/exact_trace.comp"), &bindings, &constants, 4)?,
            resolve: mask
                .map(|mask| {
                    let bindings = [c, Binding::Storage(&items), v, Binding::StorageImage(mask)];
                    let words = spirv!("engine/exact_resolve.comp");
                    Compute::new(gpu, "exact_resolve", words, &bindings, &[config.mask_bits, config.samples], 4)
                })
                .transpose()?,
            items,
            count,
            rays,
            visibility,
            arguments,
            capacity,
            device: gpu.device.clone(),
        })
    }

    pub(crate) fn bytes(&self) -> u64 {
        [&self.count, &self.rays, &self.visibility, &self.items, &self.arguments].iter().map(|b| b.size).sum()
    }

    /// Traces; the caller has ordered the writes of items, rays and tree before compute reads.
    pub(crate) fn record(&self, cmd: vk::CommandBuffer) {
        use Access::*;
        self.prepare.dispatch(cmd, &self.capacity, [1, 1, 1]);
        sync::barrier(&self.device, cmd, &[(ComputeWrite, ComputeWrite), (ComputeWrite, IndirectRead)]);
        self.trace.dispatch_indirect(cmd, &self.capacity, &self.arguments, 0);
        if let Some(resolve) = &self.resolve {
            sync::barrier(&self.device, cmd, &[(ComputeWrite, ComputeWrite)]);
            resolve.dispatch_indirect(cmd, &self.capacity, &self.arguments, 0);
        }
    }
}
