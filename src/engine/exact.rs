//! Rays of listed items: what the shadow map cannot decide, decided by the casters. Rays go through the tree of
//! [`super::bvh`] or, where the device has ray queries, through the structure of [`super::query`].
//! Reads: number of items, rays, frame constants, tree or structure, the scene. Writes: visibility, a word an item: 1 lit, 0 shadowed.
//! At capacity: the rest is not traced.

use super::bvh::Bvh;
use super::query::RayQuery;
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Buffer, Compute, Gpu, Image, spirv};
use crate::host::SceneBuffers;
use crate::{Config, Error};
use ash::vk;
use std::sync::Arc;

/// Origin and direction of a ray.
pub(crate) const RAY_BYTES: u32 = 32;

/// Points where rays meet casters, for `glsl/shared/ray_hit.glsl`.
pub(crate) fn hit_bindings(scene: &SceneBuffers) -> [Binding<'static>; 5] {
    let [positions, attributes] = scene.vertices();
    [scene.instances, positions, attributes, scene.materials, scene.texels].map(Binding::External)
}

pub(crate) struct Exact {
    /// What rays go through where there is no tree.
    pub(crate) query: Option<RayQuery>,
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
    /// `bvh`: the tree that rays walk through, `None` for ray queries; `frame`: constants of the view; `mask`: where the
    /// lookup left zeros for the items.
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        config: &Config,
        scene: &SceneBuffers,
        bvh: Option<&Bvh>,
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
        let query = match (bvh, scene.shapes) {
            (None, Some(shapes)) => Some(RayQuery::new(gpu, scene, shapes, frame)?),
            _ => None,
        };
        let own = [c, r, v, frame];
        let trace = |name, words, rays: &[Binding<'_>], constants: &[u32]| {
            Compute::new(gpu, name, words, &[&own, rays].concat(), constants, 4)
        };
        let trace = match (bvh, &query) {
            (Some(bvh), _) => {
                trace("exact_trace", spirv!("engine/exact_trace.comp"), &bvh.ray_bindings(), &bvh.ray_constants(config))
            }
            (None, Some(query)) => {
                let position = scene.position_layout.words();
                let constants = [[config.cull as u32, u32::from(scene.alpha_tested)].as_slice(), &position].concat();
                trace("exact_query", spirv!("engine/exact_query.comp"), &query.bindings(scene), &constants)
            }
            (None, None) => Err(Error::Unsupported { what: "ray queries without structures of the meshes".into() }),
        }?;
        Ok(Self {
            prepare: Compute::new(gpu, "exact_prepare", spirv!("engine/exact_prepare.comp"), &[c, a], &[], 4)?,
            trace,
            resolve: mask
                .map(|mask| {
                    let bindings = [c, Binding::Storage(&items), v, Binding::StorageImage(mask)];
                    let words = spirv!("engine/exact_resolve.comp");
                    Compute::new(gpu, "exact_resolve", words, &bindings, &[config.mask_bits, config.samples], 4)
                })
                .transpose()?,
            query,
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
        let own = [&self.count, &self.rays, &self.visibility, &self.items, &self.arguments];
        own.iter().map(|b| b.size).sum::<u64>() + self.query.as_ref().map_or(0, RayQuery::bytes)
    }

    /// Traces; the caller has ordered the writes of items, rays and tree before compute reads, the structure's build before
    /// it is read.
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
