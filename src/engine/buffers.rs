//! Everything the engine keeps on the device, allocated once.

use super::constants::FACES;
use crate::gpu::structs::{
    COMMAND_BYTES, Counters, Frame, ITEM_BYTES, LightRecord, Node, PAIR_BYTES, PAIR_KINDS, Page, RUN, Slot, Tracked,
};
use crate::gpu::{Binding, Buffer, Gpu, Image, ImageSpec, Memory};
use crate::host::SceneBuffers;
use crate::{Config, Error};
use ash::vk;
use std::sync::Arc;

/// Words of the indirect arguments, in order.
pub(crate) mod arguments {
    /// Dispatch of request attempts 1 to 3; the fourth is never used.
    pub(crate) const RETRY: [u32; 4] = [0, 3, 6, 9];
    /// Dispatch over the blocks of the sort in progress.
    pub(crate) const SORT: u32 = 12;
    /// Draw that clears layers.
    pub(crate) const CLEAR: u32 = 15;
    /// Dispatch over the layers that were cleared; follows the draw.
    pub(crate) const RANGES: u32 = 19;
    /// Dispatches over the runs of clusters of each layer.
    pub(crate) const ITEMS: [u32; 2] = [22, 25];
    /// Dispatches over opaque and masked pairs.
    pub(crate) const TRIANGLES: [u32; 2] = [28, 31];
    pub(crate) const WORDS: u32 = 34;
}

pub(crate) struct Buffers {
    /// Constants of each view; passes that are not of one view read the first's.
    pub(crate) frames: Vec<Buffer>,
    /// A record for each light of each view.
    pub(crate) lights: Buffer,
    /// Table slot + 1 of the root of each face.
    pub(crate) roots: Buffer,
    pub(crate) active_faces: Buffer,
    /// What fills bindings that a pass does not touch, one for each view, as lookups of several views overlap.
    pub(crate) nothing: Vec<Buffer>,
    pub(crate) counters: Buffer,
    pub(crate) readback: Buffer,
    pub(crate) arguments: Buffer,
    pub(crate) table_keys: Buffer,
    pub(crate) entries: Buffer,
    pub(crate) nodes: Buffer,
    pub(crate) node_list: Buffer,
    pub(crate) histogram: Buffer,
    /// Keys and table slots of the chosen pages.
    pub(crate) chosen: [Buffer; 2],
    pub(crate) pages: Buffer,
    pub(crate) slots: Buffer,
    pub(crate) order: Buffer,
    pub(crate) cleared: Buffer,
    /// Least and greatest depth of each layer.
    pub(crate) ranges: Buffer,
    pub(crate) tracked: Buffer,
    pub(crate) changed: Buffer,
    pub(crate) items: [Buffer; 2],
    pub(crate) pair_counts: Buffer,
    pub(crate) pairs: Buffer,
    /// Those of casters that the host draws, caster by caster.
    pub(crate) host_pairs: Option<Buffer>,
    pub(crate) commands: Buffer,
    pub(crate) atlas: Image,
}

impl Buffers {
    pub(crate) fn new(gpu: &Arc<Gpu>, config: &Config, scene: &SceneBuffers, views: u32) -> Result<Self, Error> {
        use vk::BufferUsageFlags as U;
        let none = U::empty();
        let storage = |name: &str, bytes: u64, extra: U| Buffer::storage(gpu, name, bytes, extra);
        let table = u64::from(config.table_size());
        let pages = u64::from(config.page_capacity());
        let pairs = 2 * u64::from(config.pair_capacity);
        let instances = u64::from(scene.instance_count);
        // every instance ends with a run that may not be full
        let runs = ITEM_BYTES * (u64::from(scene.caster_count / RUN) + instances);
        let faces = u64::from(config.lights * FACES);
        let records = u64::from(config.lights * views) * size_of::<LightRecord>() as u64;
        use vk::ImageUsageFlags as I;
        let frame = |_| {
            let usage = U::UNIFORM_BUFFER | U::TRANSFER_DST;
            Buffer::new(gpu, "frame constants", size_of::<Frame>() as u64, usage, Memory::Device)
        };
        Ok(Self {
            frames: (0..views).map(frame).collect::<Result<_, _>>()?,
            lights: storage("lights", records, U::TRANSFER_DST)?,
            roots: storage("roots of faces", 4 * faces, none)?,
            active_faces: storage("active faces", 2 * 4 * faces, none)?,
            nothing: (0..views).map(|_| storage("nothing", 16, none)).collect::<Result<_, _>>()?,
            counters: storage("counters", size_of::<Counters>() as u64, U::INDIRECT_BUFFER)?,
            readback: Buffer::new(
                gpu,
                "counters readback",
                size_of::<Counters>() as u64 * u64::from(config.frames_in_flight),
                U::TRANSFER_DST,
                Memory::Readback,
            )?,
            arguments: storage("indirect arguments", u64::from(arguments::WORDS) * 4, U::INDIRECT_BUFFER)?,
            table_keys: storage("page table keys", 8 * table, none)?,
            entries: storage("page table entries", 4 * table, none)?,
            nodes: storage("page quadtree", size_of::<Node>() as u64 * table, none)?,
            node_list: storage("node list", 4 * u64::from(config.node_capacity()), none)?,
            histogram: storage("rank histograms", 4 * (3 * 4096 + 8192), none)?,
            chosen: [storage("chosen keys", 8 * pages, none)?, storage("chosen nodes", 4 * pages, none)?],
            pages: storage("pages", size_of::<Page>() as u64 * pages, none)?,
            slots: storage("layers", size_of::<Slot>() as u64 * pages, none)?,
            order: storage("order of layers", 4 * pages, none)?,
            cleared: storage("layers to clear", 4 * pages, none)?,
            ranges: storage("depth ranges of layers", 8 * pages, none)?,
            tracked: storage("tracked instances", size_of::<Tracked>() as u64 * instances, none)?,
            changed: storage("changed bounds", 2 * 32 * instances, none)?,
            items: [storage("cached runs", runs, none)?, storage("moving runs", runs, none)?],
            pair_counts: storage("pair counts", 4 * 2 * PAIR_KINDS * pages, none)?,
            pairs: storage("pairs", PAIR_BYTES * pairs, none)?,
            host_pairs: scene
                .host_draws
                .map(|_| storage("pairs of the host", pairs / 2 * PAIR_BYTES, none))
                .transpose()?,
            commands: storage("draw commands", COMMAND_BYTES * pairs, U::INDIRECT_BUFFER)?,
            atlas: Image::new(
                gpu,
                "physical atlas",
                &ImageSpec {
                    format: vk::Format::D32_SFLOAT,
                    width: config.page_texels,
                    height: config.page_texels,
                    layers: config.page_capacity(),
                    usage: I::DEPTH_STENCIL_ATTACHMENT | I::SAMPLED | I::TRANSFER_SRC,
                },
            )?,
        })
    }

    /// Constants of a view.
    pub(crate) fn frame(&self, view: usize) -> Binding<'_> {
        Binding::Uniform(&self.frames[view])
    }

    /// Device memory by purpose, in bytes.
    pub(crate) fn memory(&self) -> Vec<(&'static str, u64)> {
        vec![
            ("atlas", self.atlas.bytes),
            ("page_table", self.table_keys.size + self.entries.size + self.nodes.size),
            (
                "requests",
                self.node_list.size
                    + self.histogram.size
                    + self.roots.size
                    + self.active_faces.size
                    + self.chosen[0].size
                    + self.chosen[1].size
                    + self.pages.size
                    + self.slots.size
                    + self.order.size
                    + self.cleared.size
                    + self.ranges.size,
            ),
            ("casters", self.tracked.size + self.changed.size + self.items[0].size + self.items[1].size),
            (
                "draw_lists",
                self.pair_counts.size
                    + self.pairs.size
                    + self.host_pairs.as_ref().map_or(0, |pairs| pairs.size)
                    + self.commands.size,
            ),
            (
                "other",
                self.frames.iter().map(|frame| frame.size).sum::<u64>()
                    + self.lights.size
                    + self.counters.size
                    + self.readback.size
                    + self.arguments.size,
            ),
        ]
    }
}
