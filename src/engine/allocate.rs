//! From requested pages to page table entries, within the atlas.
//!
//! The requested pages and their ancestors form a quadtree for each face of each light. A root gets its page before any
//! page is refined, so that no light starves while another has finer shadows than one page gives. Refining a node replaces its page by its children's; what
//! that gains (pixels, weighted with how far they are from their wish) per page it costs is the node's rank, the
//! thesis' benefit per cost (Fernando 2002, section 2.4). One histogram over the ranks finds the threshold at which the
//! atlas is full, so that the memory given is spent where it helps most and nothing depends on the order of threads. Where
//! more would have to be drawn than a frame may, a second threshold holds back those that draw.
//!
//! Reads: page table keys and pixel counts (flags route) or distinct keys (sort route). Writes: nodes, pages, entries.
//! At capacity: coarser pages serve; refusals are counted.

use super::buffers::Buffers;
use super::compact::Compact;
use super::request::SHIFTS;
use crate::gpu::structs::ChoosePush;
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Compute, Gpu, spirv};
use crate::{Config, Error};
use ash::vk;
use std::sync::Arc;

/// Workgroups of the passes that stride over all nodes.
const GROUPS: [u32; 3] = [32, 1, 1];

pub(crate) struct Allocate {
    insert: Option<Compute>,
    ancestors: Compute,
    rank: Compute,
    path: Compute,
    choose: Compute,
    defer: Compute,
    select: Compute,
    pages: Compute,
    entries: Compute,
    tolerance: i32,
    device: ash::Device,
}

impl Allocate {
    /// `pixels`: of all views.
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        config: &Config,
        pixels: u64,
        b: &Buffers,
        compact: Option<&Compact>,
    ) -> Result<Self, Error> {
        let table = config.table_size();
        let nodes = config.node_capacity();
        let counters = Binding::Storage(&b.counters);
        let (keys, node, list) =
            (Binding::Storage(&b.table_keys), Binding::Storage(&b.nodes), Binding::Storage(&b.node_list));
        let histogram = Binding::Storage(&b.histogram);
        let (chosen_keys, chosen_nodes) = (Binding::Storage(&b.chosen[0]), Binding::Storage(&b.chosen[1]));
        let (frame, lights) = (b.frame(0), Binding::Storage(&b.lights));
        let (page, slots) = (Binding::Storage(&b.pages), Binding::Storage(&b.slots));
        let insert = compact.map(|c| {
            let bindings = [counters, Binding::Storage(&c.keys), Binding::Storage(&c.counts), keys, node, list];
            let constants = [table, config.request_capacity(), SHIFTS[1], SHIFTS[2], SHIFTS[3]];
            Compute::new(gpu, "allocate_insert", spirv!("engine/allocate_insert.comp"), &bindings, &constants, 0)
        });
        Ok(Self {
            insert: insert.transpose()?,
            ancestors: Compute::new(
                gpu,
                "allocate_ancestors",
                spirv!("engine/allocate_ancestors.comp"),
                &[counters, keys, node, list, frame, lights, Binding::Storage(&b.roots)],
                &[table, nodes, config.weight_bits(pixels)],
                0,
            )?,
            rank: Compute::new(
                gpu,
                "allocate_rank",
                spirv!("engine/allocate_rank.comp"),
                &[counters, node, list, keys],
                &[nodes, table, config.pressure as u32],
                0,
            )?,
            path: Compute::new(
                gpu,
                "allocate_path",
                spirv!("engine/allocate_path.comp"),
                &[counters, node, list, histogram, keys, lights],
                &[nodes, table],
                0,
            )?,
            choose: Compute::new(
                gpu,
                "allocate_choose",
                spirv!("engine/allocate_choose.comp"),
                &[counters, histogram],
                &[config.chosen_layers()],
                size_of::<ChoosePush>(),
            )?,
            defer: Compute::new(
                gpu,
                "allocate_defer",
                spirv!("engine/allocate_defer.comp"),
                &[counters, node, list, histogram, keys, lights],
                &[nodes, table],
                size_of::<ChoosePush>(),
            )?,
            select: Compute::new(
                gpu,
                "allocate_select",
                spirv!("engine/allocate_select.comp"),
                &[counters, node, list, chosen_keys, chosen_nodes, keys, lights],
                &[nodes, config.page_capacity(), table],
                0,
            )?,
            pages: Compute::new(
                gpu,
                "allocate_pages",
                spirv!("engine/allocate_pages.comp"),
                &[
                    frame,
                    counters,
                    node,
                    chosen_keys,
                    chosen_nodes,
                    page,
                    Binding::Storage(&b.pair_counts),
                    slots,
                    lights,
                ],
                &[config.page_capacity()],
                0,
            )?,
            entries: Compute::new(
                gpu,
                "allocate_entries",
                spirv!("engine/allocate_entries.comp"),
                &[counters, node, list, page, Binding::Storage(&b.entries), slots, keys],
                &[nodes, table],
                4,
            )?,
            tolerance: (-config.level_bias).ceil().max(0.0) as i32,
            device: gpu.device.clone(),
        })
    }

    /// The quadtree above the requests.
    pub(crate) fn record_tree(&self, cmd: vk::CommandBuffer) {
        if let Some(insert) = &self.insert {
            insert.dispatch(cmd, &(), GROUPS);
            sync::barrier(&self.device, cmd, &[(Access::ComputeWrite, Access::ComputeWrite)]);
        }
        self.ancestors.dispatch(cmd, &(), GROUPS);
    }

    /// The sorted list of pages, at most `draws` layers of which must be drawn.
    pub(crate) fn record_pages(&self, cmd: vk::CommandBuffer, draws: u32) {
        let next = || sync::barrier(&self.device, cmd, &[(Access::ComputeWrite, Access::ComputeWrite)]);
        self.rank.dispatch(cmd, &(), GROUPS);
        next();
        self.path.dispatch(cmd, &(), GROUPS);
        next();
        let push = |step| ChoosePush { draw_budget: draws as i32, step };
        self.choose.dispatch(cmd, &push(0), [1, 1, 1]);
        next();
        for step in [1, 2] {
            self.defer.dispatch(cmd, &push(step), GROUPS);
            next();
            self.choose.dispatch(cmd, &push(step), [1, 1, 1]);
            next();
        }
        self.select.dispatch(cmd, &(), GROUPS);
        next();
        self.pages.dispatch(cmd, &(), [16, 1, 1]);
    }

    /// Page table entries, once it is known which pages serve.
    pub(crate) fn record_entries(&self, cmd: vk::CommandBuffer) {
        self.entries.dispatch(cmd, &self.tolerance, GROUPS);
    }
}
