//! The tree over all casters that rays walk through: built on the GPU, again only where something changed.
//!
//! At the bottom a tree for each cluster, in mesh space and shared by all instances: halved along the longest axis of the
//! triangles' centres, four boxes a node, leaves of two triangles. At the top a tree over the casters (clusters of
//! instances) along a Hilbert curve: rays visit a sixth fewer nodes than in Morton order. No node
//! points anywhere: see `glsl/shared/bvh.glsl`. 27 bytes a triangle of the scene, about 110 a caster with all that builds
//! the tree.
//!
//! Reads: instances, meshes, clusters, indices, positions, changes. Writes: the tree. It has room for every caster that the
//! scene's buffers may hold; casters beyond that number are left out.

use super::exact;
use super::sort::{BLOCK, Passes};
use crate::gpu::structs::Counters;
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Buffer, Compute, Gpu, spirv};
use crate::host::SceneBuffers;
use crate::{Config, Error};
use ash::vk;
use std::sync::Arc;

/// Bits of the change of an instance: matrix, mesh, material or flags.
#[cfg(feature = "lab")]
pub const CHANGED_PLACE: u32 = 1;
/// Vertices of its mesh, another mesh, or a mesh that cast nothing before: its clusters' trees are built.
#[cfg(feature = "lab")]
pub const CHANGED_SHAPE: u32 = 2;

/// Most workgroups over the clusters to build.
const CLUSTER_GROUPS: u32 = 4096;
/// Passes of the sort: 4 bits each of 30-bit keys.
const DIGITS: u32 = 8;
/// Most nodes of a cluster.
const CLUSTER_NODES: u64 = 21;

/// Indirect dispatches, three words each.
mod argument {
    pub(super) const CASTERS: u32 = 0;
    pub(super) const BLOCKS: u32 = 1;
    pub(super) const ONE: u32 = 2;
    pub(super) const CLUSTERS: u32 = 3;
    pub(super) const LEVELS: u32 = 4;
}

pub(crate) struct Bvh {
    /// Input, filled before [`Bvh::record`]: a word that is not 0 where anything changed, then `CHANGED_*` for each instance;
    /// in the first frame all are [`CHANGED_SHAPE`].
    pub(crate) changes: Buffer,
    tree: Buffer,
    firsts: Buffer,
    counters: Buffer,
    sort: Passes,
    listed: Buffer,
    list: Buffer,
    arguments: Buffer,
    scan: Compute,
    key: Compute,
    clusters: Compute,
    casters: Compute,
    top: Compute,
    /// Constants 0 to 10 of `glsl/shared/bvh.glsl`.
    constants: [u32; 11],
    scene: SceneBuffers,
    device: ash::Device,
}

/// Levels of top nodes over a number of casters.
fn top_levels(casters: u32) -> u32 {
    (casters.max(2) - 1).ilog2() / 2 + 1
}

/// Constants of `glsl/shared/bvh.glsl`, and the words of four that the tree needs.
fn layout(scene: &SceneBuffers) -> ([u32; 11], u64) {
    let casters = scene.caster_count.max(1);
    let levels = top_levels(casters);
    let triangles = u64::from(scene.index_count / 3);
    let top = ((1u64 << (2 * (levels - 1))) - 1) / 3 + u64::from(casters.div_ceil(4));
    let first_caster = 3 * top;
    let first_node = first_caster + 4 * u64::from(casters);
    let first_triangle = first_node + 2 * (triangles / 3 + CLUSTER_NODES);
    let size = |i: usize| scene.bounds_max[i] - scene.bounds_min[i];
    let least = 1e-6 * size(0).max(size(1)).max(size(2)) + 1e-30;
    // a step on every side is left free for the rounding of boxes
    let steps = [0, 1, 2].map(|i| 65533.0 / size(i).max(least));
    let low = [0, 1, 2].map(|i| (scene.bounds_min[i] - 1.0 / steps[i]) as f32);
    let [x, y, z] = low.map(f32::to_bits);
    let [sx, sy, sz] = steps.map(|s| (s as f32).to_bits());
    let words = [first_caster, first_node, first_triangle].map(|w| w as u32);
    let constants = [casters, levels, words[0], words[1], words[2], x, y, z, sx, sy, sz];
    (constants, first_triangle + triangles)
}

impl Bvh {
    pub(crate) fn new(gpu: &Arc<Gpu>, scene: &SceneBuffers) -> Result<Self, Error> {
        let (constants, words) = layout(scene);
        let [casters, levels, ..] = constants;
        let most = 64 * 65535;
        if casters > most {
            let limit = format!("at most {most}");
            return Err(Error::Limit { field: "caster_count", given: casters.to_string(), limit });
        }
        let none = vk::BufferUsageFlags::empty();
        let storage = |name: &str, words: u64| Buffer::storage(gpu, name, 4 * words, none);
        let many = u64::from(casters);
        let changes = storage("changes", 1 + u64::from(scene.instance_count))?;
        let tree = storage("tree", 4 * words)?;
        let firsts = storage("first casters", 1 + u64::from(scene.instance_count))?;
        let counters = Buffer::storage(gpu, "caster counters", size_of::<Counters>() as u64, none)?;
        let sort = Passes::new(gpu, &counters, casters)?;
        let listed = storage("clusters listed", 1 + u64::from(scene.index_count) / 96)?;
        let list = storage("clusters to build", 1 + many)?;
        let size = 12 * u64::from(argument::LEVELS + levels);
        let arguments = Buffer::storage(gpu, "caster dispatches", size, vk::BufferUsageFlags::INDIRECT_BUFFER)?;
        let own = |buffer| Binding::Storage(buffer);
        let with = |more: &[u32]| [constants.as_slice(), more].concat();
        let (instances, meshes) = (Binding::External(scene.instances), Binding::External(scene.meshes));
        let clusters = Binding::External(scene.clusters);
        let scan = [own(&counters), instances, meshes, own(&changes), own(&firsts), own(&arguments)];
        let key = [
            instances,
            meshes,
            clusters,
            own(&firsts),
            own(&changes),
            own(&sort.keys[0]),
            own(&sort.values[0]),
            own(&listed),
            own(&list),
            own(&arguments),
        ];
        let (indices, positions) = (Binding::External(scene.indices), Binding::External(scene.positions));
        let build = [own(&list), clusters, indices, positions, own(&tree)];
        let place = [instances, meshes, clusters, own(&firsts), own(&sort.values[0]), own(&tree)];
        let count_of = scene.instance_count;
        Ok(Self {
            scan: Compute::new(gpu, "bvh_scan", spirv!("engine/bvh_scan.comp"), &scan, &with(&[count_of, BLOCK]), 0)?,
            key: Compute::new(
                gpu,
                "bvh_keys",
                spirv!("engine/bvh_keys.comp"),
                &key,
                &with(&[count_of, CLUSTER_GROUPS]),
                0,
            )?,
            clusters: Compute::new(
                gpu,
                "bvh_clusters",
                spirv!("engine/bvh_clusters.comp"),
                &build,
                &with(&scene.position_layout.words()),
                0,
            )?,
            casters: Compute::new(
                gpu,
                "bvh_casters",
                spirv!("engine/bvh_casters.comp"),
                &place,
                &with(&[count_of]),
                0,
            )?,
            top: Compute::new(gpu, "bvh_top", spirv!("engine/bvh_top.comp"), &[own(&tree)], &constants, 4)?,
            changes,
            tree,
            firsts,
            counters,
            sort,
            listed,
            list,
            arguments,
            constants,
            scene: *scene,
            device: gpu.device.clone(),
        })
    }

    /// The constants that a shader with `glsl/shared/ray.glsl` begins with.
    pub(crate) fn ray_constants(&self, config: &Config) -> Vec<u32> {
        let rule = [config.cull as u32, u32::from(self.scene.alpha_tested)];
        [self.constants.as_slice(), &rule, &self.scene.position_layout.words()].concat()
    }

    /// The bindings of such a shader, from its `RAY_BINDING`.
    pub(crate) fn ray_bindings(&self) -> Vec<Binding<'_>> {
        [[Binding::Storage(&self.tree)].as_slice(), &exact::hit_bindings(&self.scene)].concat()
    }

    /// Device memory in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        let own = [&self.changes, &self.tree, &self.firsts, &self.counters, &self.listed, &self.list, &self.arguments];
        own.map(|b| b.size).iter().sum::<u64>() + self.sort.bytes()
    }

    /// Resets what [`Bvh::record`] counts. The caller orders this before it as transfer writes before compute.
    pub(crate) fn record_reset(&self, cmd: vk::CommandBuffer) {
        // SAFETY: the command buffer is recording; storage buffers can be filled
        unsafe {
            self.device.cmd_fill_buffer(cmd, self.listed.raw, 0, vk::WHOLE_SIZE, 0);
            self.device.cmd_fill_buffer(cmd, self.list.raw, 0, 4, 0);
        }
    }

    /// Brings the tree up to date with what `changes` says; the caller has ordered writes of the scene's buffers and of the
    /// changes before compute reads, and earlier indirect reads before compute writes. Compute shaders may read the tree
    /// after a further barrier from compute writes.
    pub(crate) fn record(&self, cmd: vk::CommandBuffer) {
        use Access::*;
        let next = || sync::barrier(&self.device, cmd, &[(ComputeWrite, ComputeWrite)]);
        let indirect = |pass: &Compute, push: u32, argument: u32| {
            pass.dispatch_indirect(cmd, &push, &self.arguments, 12 * u64::from(argument));
        };
        let plain = |pass: &Compute, argument: u32| {
            pass.dispatch_indirect(cmd, &(), &self.arguments, 12 * u64::from(argument));
        };
        self.scan.dispatch(cmd, &(), [1, 1, 1]);
        sync::barrier(&self.device, cmd, &[(ComputeWrite, ComputeWrite), (ComputeWrite, IndirectRead)]);
        plain(&self.key, argument::CASTERS);
        sync::barrier(
            &self.device,
            cmd,
            &[(ComputeWrite, ComputeWrite), (ComputeWrite, IndirectRead), (IndirectRead, ComputeWrite)],
        );
        // clusters and the first count are independent; clusters dominate
        plain(&self.clusters, argument::CLUSTERS);
        let [blocks, one] = [argument::BLOCKS, argument::ONE].map(|i| 12 * u64::from(i));
        self.sort.record(cmd, DIGITS, &self.arguments, blocks, Some(one));
        plain(&self.casters, argument::CASTERS);
        next();
        for level in (0..self.constants[1] - 1).rev() {
            indirect(&self.top, level, argument::LEVELS + level);
            next();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::top_levels;

    #[test]
    fn levels_hold_all_casters() {
        for (casters, levels) in [(0, 1), (1, 1), (4, 1), (5, 2), (16, 2), (17, 3), (64, 3), (65, 4), (1 << 22, 11)] {
            assert_eq!(top_levels(casters), levels, "{casters} casters");
        }
    }
}
