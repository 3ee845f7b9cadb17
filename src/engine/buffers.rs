//! Everything the engine keeps on the device, allocated once.

use crate::gpu::structs::{COMMAND_BYTES, Counters, Frame, Node, PAIR_BYTES, Page};
use crate::gpu::{Buffer, Gpu, Image, ImageSpec, Memory};
use crate::{Config, Error};
use ash::vk;
use std::sync::Arc;

/// Words of the indirect arguments, in order.
pub(crate) mod arguments {
    /// Dispatch of request attempts 1 to 3; the fourth is never used.
    pub(crate) const RETRY: [u32; 4] = [0, 3, 6, 9];
    /// Dispatch over the blocks of the sort in progress.
    pub(crate) const SORT: u32 = 12;
    /// Draw that clears pages, then the triangle dispatches of opaque and masked pairs.
    pub(crate) const CULL: u32 = 15;
    pub(crate) const CLEAR: u32 = CULL;
    pub(crate) const TRIANGLES: [u32; 2] = [CULL + 4, CULL + 7];
    pub(crate) const WORDS: u32 = CULL + 10;
}

pub(crate) struct Buffers {
    pub(crate) frame: Buffer,
    pub(crate) counters: Buffer,
    pub(crate) readback: Buffer,
    pub(crate) arguments: Buffer,
    pub(crate) table_keys: Buffer,
    pub(crate) entries: Buffer,
    pub(crate) nodes: Buffer,
    pub(crate) node_list: Buffer,
    pub(crate) histogram: Buffer,
    pub(crate) pages: Buffer,
    pub(crate) pair_counts: Buffer,
    pub(crate) pairs: Buffer,
    pub(crate) commands: Buffer,
    pub(crate) receiver: Image,
    pub(crate) atlas: Image,
    pub(crate) visibility: Image,
}

impl Buffers {
    pub(crate) fn new(gpu: &Arc<Gpu>, config: &Config) -> Result<Self, Error> {
        use vk::BufferUsageFlags as U;
        let none = U::empty();
        let storage = |name: &str, bytes: u64, extra: U| Buffer::storage(gpu, name, bytes, extra);
        let table = u64::from(config.table_size());
        let pages = u64::from(config.page_capacity());
        let pairs = 2 * u64::from(config.pair_capacity);
        let [width, height] = config.size;
        let screen =
            |name, format, usage| Image::new(gpu, name, &ImageSpec { format, width, height, layers: 0, usage });
        use vk::ImageUsageFlags as I;
        Ok(Self {
            frame: Buffer::new(
                gpu,
                "frame constants",
                size_of::<Frame>() as u64,
                U::UNIFORM_BUFFER | U::TRANSFER_DST,
                Memory::Device,
            )?,
            counters: storage("counters", size_of::<Counters>() as u64, U::INDIRECT_BUFFER)?,
            readback: Buffer::new(
                gpu,
                "counters readback",
                size_of::<Counters>() as u64,
                U::TRANSFER_DST,
                Memory::Readback,
            )?,
            arguments: storage("indirect arguments", u64::from(arguments::WORDS) * 4, U::INDIRECT_BUFFER)?,
            table_keys: storage("page table keys", 4 * table, none)?,
            entries: storage("page table entries", 4 * table, none)?,
            nodes: storage("page quadtree", size_of::<Node>() as u64 * table, none)?,
            node_list: storage("node list", 4 * u64::from(config.node_capacity()), none)?,
            histogram: storage("rank histogram", 4 * 2048, none)?,
            pages: storage("pages", size_of::<Page>() as u64 * pages, none)?,
            pair_counts: storage("pair counts", 8 * pages, none)?,
            pairs: storage("pairs", PAIR_BYTES * pairs, none)?,
            commands: storage("draw commands", COMMAND_BYTES * pairs, U::INDIRECT_BUFFER)?,
            receiver: screen("receiver planes", vk::Format::R32G32B32A32_UINT, I::STORAGE | I::SAMPLED)?,
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
            visibility: screen("visibility", vk::Format::R32_SFLOAT, I::STORAGE | I::TRANSFER_SRC)?,
        })
    }

    /// Device memory by purpose, in bytes.
    pub(crate) fn memory(&self) -> Vec<(&'static str, u64)> {
        vec![
            ("atlas", self.atlas.bytes),
            ("page_table", self.table_keys.size + self.entries.size + self.nodes.size),
            ("requests", self.node_list.size + self.histogram.size + self.pages.size),
            ("draw_lists", self.pair_counts.size + self.pairs.size + self.commands.size),
            ("screen", self.receiver.bytes + self.visibility.bytes),
            ("other", self.frame.size + self.counters.size + self.readback.size + self.arguments.size),
        ]
    }
}
