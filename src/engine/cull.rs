//! Which cluster is drawn into which page, and which of its triangles: instances against the pages that are drawn, then
//! their clusters, then triangles. Casters that the host draws itself: which pages they touch.
//! Reads: nodes, pages, instances, clusters. Writes: pairs page by page, draw commands, compacted indices, admission;
//! for the host's casters pairs caster by caster, and the host's draw commands.
//! At capacity of pairs: the roots and the pages with the most pixels per cost are admitted, the rest is put off before
//! anything is drawn into it. At capacity of indices: whole clusters are drawn.

use super::buffers::{Buffers, arguments};
use super::constants::FACES;
use crate::gpu::structs::{ItemPush, TrianglePush};
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Compute, Gpu, spirv};
use crate::host::SceneBuffers;
use crate::{Config, Error};
use ash::vk;
use std::sync::Arc;

const DISPATCH_X: u32 = 32768;

/// Workgroups of 64 threads for a list.
pub(super) fn groups(threads: u32) -> [u32; 3] {
    let groups = threads.div_ceil(64);
    [groups.min(DISPATCH_X), groups.div_ceil(DISPATCH_X), 1]
}

pub(crate) struct Cull {
    faces: Compute,
    prepare: Compute,
    touch: Compute,
    instances: Compute,
    /// For each layer.
    count: [Compute; 2],
    admit: Compute,
    emit: [Compute; 2],
    triangles: Compute,
    /// Where the host draws casters, for each layer.
    host: Option<[Compute; 2]>,
    instance_count: u32,
    face_groups: u32,
    first_compacted: u32,
    device: ash::Device,
}

impl Cull {
    pub(crate) fn new(gpu: &Arc<Gpu>, config: &Config, b: &Buffers, scene: &SceneBuffers) -> Result<Self, Error> {
        let faces = config.lights * FACES;
        let position = scene.position_layout.words();
        let walk = [config.page_texels, config.gutter, config.table_size(), faces];
        let frame = b.frame(0);
        let (counters, nodes) = (Binding::Storage(&b.counters), Binding::Storage(&b.nodes));
        let (pages, counts, pairs) =
            (Binding::Storage(&b.pages), Binding::Storage(&b.pair_counts), Binding::Storage(&b.pairs));
        let (instances, meshes) = (Binding::External(scene.instances), Binding::External(scene.meshes));
        let clusters = Binding::External(scene.clusters);
        let items = [Binding::Storage(&b.items[0]), Binding::Storage(&b.items[1])];
        let arguments = Binding::Storage(&b.arguments);
        let lights = Binding::Storage(&b.lights);
        // what a walk down the quadtrees needs
        let trees =
            [Binding::Storage(&b.table_keys), lights, Binding::Storage(&b.roots), Binding::Storage(&b.active_faces)];
        let count = |layer: usize| {
            let bindings = [frame, counters, nodes, items[layer], instances, meshes, clusters, pages, counts];
            let bindings = [&bindings[..], &trees].concat();
            Compute::new(gpu, "cull_count", spirv!("engine/cull_count.comp"), &bindings, &walk, 4)
        };
        let emit = |layer: usize| {
            let bindings = [frame, counters, nodes, items[layer], instances, meshes, clusters, pages, counts, pairs];
            let bindings = [&bindings[..], &trees].concat();
            let constants = [walk[0], walk[1], walk[2], walk[3], config.pair_capacity];
            Compute::new(gpu, "cull_emit", spirv!("engine/cull_emit.comp"), &bindings, &constants, 4)
        };
        let host = |layer: usize, list, draws| {
            let bindings = [frame, counters, nodes, items[layer], instances, meshes, clusters, pages, list];
            let bindings = [&bindings[..], &trees, &[draws]].concat();
            Compute::new(gpu, "cull_host", spirv!("engine/cull_host.comp"), &bindings, &walk, 4)
        };
        let host = match (&b.host_pairs, scene.host_draws) {
            (Some(list), Some(draws)) => {
                let (list, draws) = (Binding::Storage(list), Binding::External(draws));
                Some([host(0, list, draws)?, host(1, list, draws)?])
            }
            _ => None,
        };
        Ok(Self {
            host,
            faces: Compute::new(
                gpu,
                "cull_faces",
                spirv!("engine/cull_faces.comp"),
                &[frame, counters, nodes, Binding::Storage(&b.roots), Binding::Storage(&b.active_faces)],
                &[faces],
                4,
            )?,
            prepare: Compute::new(
                gpu,
                "cull_prepare",
                spirv!("engine/cull_prepare.comp"),
                &[counters, arguments],
                &[DISPATCH_X],
                size_of::<ItemPush>(),
            )?,
            touch: Compute::new(
                gpu,
                "cull_touch",
                spirv!("engine/cull_touch.comp"),
                &[&[frame, counters, nodes, items[1], instances, meshes, clusters], &trees[..]].concat(),
                &walk,
                0,
            )?,
            instances: Compute::new(
                gpu,
                "cull_instances",
                spirv!("engine/cull_instances.comp"),
                &[
                    &[frame, counters, nodes, instances, meshes, Binding::Storage(&b.tracked), pages, items[0]],
                    &trees[..],
                ]
                .concat(),
                &walk,
                4,
            )?,
            count: [count(0)?, count(1)?],
            admit: Compute::new(
                gpu,
                "cull_admit",
                spirv!("engine/cull_admit.comp"),
                &[frame, counters, pages, counts, arguments, nodes, lights],
                &[config.pair_capacity, DISPATCH_X],
                4,
            )?,
            emit: [emit(0)?, emit(1)?],
            triangles: Compute::new(
                gpu,
                "cull_triangles",
                spirv!("engine/cull_triangles.comp"),
                &[
                    frame,
                    counters,
                    pages,
                    pairs,
                    clusters,
                    instances,
                    Binding::External(scene.positions),
                    Binding::External(scene.indices),
                    Binding::Storage(&b.commands),
                    Binding::External(scene.meshlets),
                    lights,
                ],
                &[
                    [walk[0], walk[1], config.pair_capacity, config.index_capacity, config.cull_group].as_slice(),
                    &position,
                ]
                .concat(),
                size_of::<TrianglePush>(),
            )?,
            instance_count: scene.instance_count,
            face_groups: faces.div_ceil(64),
            first_compacted: scene.index_count,
            device: gpu.device.clone(),
        })
    }

    /// Dispatch size over the runs of a layer.
    fn record_prepare(&self, cmd: vk::CommandBuffer, layer: usize) {
        let push = ItemPush { layer: layer as u32, argument: arguments::ITEMS[layer] };
        self.prepare.dispatch(cmd, &push, [1, 1, 1]);
        sync::barrier(
            &self.device,
            cmd,
            &[(Access::ComputeWrite, Access::ComputeWrite), (Access::ComputeWrite, Access::IndirectRead)],
        );
    }

    /// Lists the faces that matter: 0 those with pages, 1 those with pages to draw.
    fn record_faces(&self, cmd: vk::CommandBuffer, list: u32) {
        self.faces.dispatch(cmd, &list, [self.face_groups, 1, 1]);
    }

    /// Marks the pages that moving clusters touch.
    pub(crate) fn record_touch(&self, cmd: vk::CommandBuffer, b: &Buffers) {
        self.record_faces(cmd, 0);
        self.record_prepare(cmd, 1);
        self.touch.dispatch_indirect(cmd, &(), &b.arguments, 4 * u64::from(arguments::ITEMS[1]));
    }

    /// Counts the pairs of the pages that are drawn and admits pages.
    pub(crate) fn record_admission(&self, cmd: vk::CommandBuffer, b: &Buffers) {
        self.record_faces(cmd, 1);
        sync::barrier(&self.device, cmd, &[(Access::ComputeWrite, Access::ComputeWrite)]);
        self.instances.dispatch(cmd, &self.instance_count, groups(self.instance_count));
        sync::barrier(&self.device, cmd, &[(Access::ComputeWrite, Access::ComputeWrite)]);
        self.record_prepare(cmd, 0);
        self.record_layers(cmd, b, &self.count);
        sync::barrier(&self.device, cmd, &[(Access::ComputeWrite, Access::ComputeWrite)]);
        self.admit.dispatch(cmd, &arguments::TRIANGLES[0], [1, 1, 1]);
    }

    /// Writes the pairs.
    pub(crate) fn record_pairs(&self, cmd: vk::CommandBuffer, b: &Buffers) {
        self.record_layers(cmd, b, &self.emit);
        if let Some(host) = &self.host {
            self.record_layers(cmd, b, host);
        }
    }

    /// Both layers touch different words.
    fn record_layers(&self, cmd: vk::CommandBuffer, b: &Buffers, passes: &[Compute; 2]) {
        for (layer, pass) in passes.iter().enumerate() {
            pass.dispatch_indirect(cmd, &(layer as u32), &b.arguments, 4 * u64::from(arguments::ITEMS[layer]));
        }
    }

    /// Turns pairs into draws.
    pub(crate) fn record_triangles(&self, cmd: vk::CommandBuffer, b: &Buffers) {
        for masked in 0..2 {
            let push = TrianglePush { masked, first_compacted: self.first_compacted };
            let offset = 4 * u64::from(arguments::TRIANGLES[masked as usize]);
            self.triangles.dispatch_indirect(cmd, &push, &b.arguments, offset);
        }
    }
}
