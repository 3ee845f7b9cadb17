//! Which cluster is drawn into which page, and which of its triangles.
//! Reads: nodes, pages, casters. Writes: pairs page by page, draw commands, compacted indices, admission of pages.
//! At capacity of pairs: the roots and the pages with the most pixels per pair are admitted, the rest is refused before
//! anything is drawn into it. At capacity of indices: whole clusters are drawn.

use super::buffers::{Buffers, arguments};
use crate::gpu::structs::{CasterPush, TrianglePush};
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Compute, Gpu, spirv};
use crate::host::SceneBuffers;
use crate::{Config, Error};
use ash::vk;
use std::sync::Arc;

const DISPATCH_X: u32 = 32768;

pub(crate) struct Cull {
    count: Compute,
    admit: Compute,
    emit: Compute,
    triangles: Compute,
    casters: CasterPush,
    first_compacted: u32,
    device: ash::Device,
}

impl Cull {
    pub(crate) fn new(gpu: &Arc<Gpu>, config: &Config, b: &Buffers, scene: &SceneBuffers) -> Result<Self, Error> {
        let page = [config.page_texels, config.gutter];
        let frame = Binding::Uniform(&b.frame);
        let (counters, nodes) = (Binding::Storage(&b.counters), Binding::Storage(&b.nodes));
        let (pages, counts, pairs) =
            (Binding::Storage(&b.pages), Binding::Storage(&b.pair_counts), Binding::Storage(&b.pairs));
        let (casters, clusters) = (Binding::External(scene.casters), Binding::External(scene.clusters));
        let instances = Binding::External(scene.instances);
        let push = size_of::<CasterPush>();
        Ok(Self {
            count: Compute::new(
                gpu,
                "cull_count",
                spirv!("engine/cull_count.comp"),
                &[frame, counters, nodes, casters, clusters, instances, counts],
                &page,
                push,
            )?,
            admit: Compute::new(
                gpu,
                "cull_admit",
                spirv!("engine/cull_admit.comp"),
                &[counters, pages, counts, Binding::Storage(&b.arguments), nodes],
                &[config.pair_capacity, DISPATCH_X],
                4,
            )?,
            emit: Compute::new(
                gpu,
                "cull_emit",
                spirv!("engine/cull_emit.comp"),
                &[frame, counters, nodes, casters, clusters, instances, counts, pages, pairs],
                &[page[0], page[1], config.pair_capacity],
                push,
            )?,
            triangles: Compute::new(
                gpu,
                "cull_triangles",
                spirv!("engine/cull_triangles.comp"),
                &[
                    frame,
                    counters,
                    pages,
                    pairs,
                    casters,
                    clusters,
                    instances,
                    Binding::External(scene.positions),
                    Binding::External(scene.indices),
                    Binding::Storage(&b.commands),
                    Binding::External(scene.meshlets),
                ],
                &[page[0], page[1], config.pair_capacity, config.index_capacity, config.cull_group],
                size_of::<TrianglePush>(),
            )?,
            casters: CasterPush { caster_count: scene.caster_count, first_masked: scene.first_masked },
            first_compacted: scene.index_count,
            device: gpu.device.clone(),
        })
    }

    /// Counts the pairs and admits pages.
    pub(crate) fn record_admission(&self, cmd: vk::CommandBuffer) {
        self.count.dispatch(cmd, &self.casters, self.groups());
        sync::barrier(&self.device, cmd, &[(Access::ComputeWrite, Access::ComputeWrite)]);
        self.admit.dispatch(cmd, &arguments::CULL, [1, 1, 1]);
    }

    /// Writes the pairs.
    pub(crate) fn record_pairs(&self, cmd: vk::CommandBuffer) {
        self.emit.dispatch(cmd, &self.casters, self.groups());
    }

    /// Turns pairs into draws.
    pub(crate) fn record_triangles(&self, cmd: vk::CommandBuffer, b: &Buffers) {
        for masked in 0..2 {
            let push = TrianglePush { masked, first_compacted: self.first_compacted };
            let offset = 4 * u64::from(arguments::TRIANGLES[masked as usize]);
            self.triangles.dispatch_indirect(cmd, &push, &b.arguments, offset);
        }
    }

    fn groups(&self) -> [u32; 3] {
        let groups = self.casters.caster_count.div_ceil(64);
        [groups.min(DISPATCH_X), groups.div_ceil(DISPATCH_X), 1]
    }
}
