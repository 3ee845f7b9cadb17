//! Maps of many tiles, one a layer, for methods whose shaders decide which tiles there are: these write the fit of each and
//! mark which are drawn, and pick the tile of each pixel. Which casters each gets is found here, on the GPU.
//! For parallel light and fits without a warp.

use super::map::Shape;
use crate::gpu::structs::{COMMAND_BYTES, Fit, TileCounts};
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Buffer, Compute, Gpu, Graphics, GraphicsState, Shaders, spirv};
use crate::lab::{Lab, LabError};
use ash::vk;
use std::mem::offset_of;
use std::sync::Arc;

/// Draws of opaque casters, and of alpha-tested ones, that there is room for at a time.
const PAIR_CAPACITY: u32 = 1 << 18;
/// Runs of clusters that there is room for at a time.
const ITEM_CAPACITY: u32 = 1 << 18;
/// Bytes of `TileItem` and `TilePair` in `glsl/methods/tile.glsl`.
const ITEM_BYTES: u64 = 12;
const PAIR_BYTES: u64 = 8;
/// Workgroups that share the list of runs.
const GROUPS: u32 = 1024;

/// What a map of tiles has beside the fits and the image.
pub(super) struct Tiles {
    /// The fit that all tiles lie in: to the visible samples, or as given.
    pub(super) root: Buffer,
    /// A word for each tile: 0 leaves what it holds, anything else has it cleared and drawn.
    pub(super) drawn: Buffer,
    /// A word for each pixel: the tile that serves it, or `NO_TILE`.
    pub(super) picked: Buffer,
    counts: Buffer,
    /// Read and written by its passes only.
    _inner: [Buffer; 2],
    pub(super) pairs: Buffer,
    commands: Buffer,
    instance_count: u32,
    list_pass: Compute,
    items_pass: Compute,
    pairs_pass: Compute,
    clear: Graphics,
    tiles: u32,
    /// Of all buffers.
    pub(super) bytes: u64,
    gpu: Arc<Gpu>,
}

impl Tiles {
    /// `light`: its constants; `fits`: of the tiles.
    pub(super) fn new(lab: &Lab, shape: &Shape, light: &Buffer, fits: &Buffer) -> Result<Self, LabError> {
        let (gpu, scene, tiles) = (lab.gpu(), lab.scene_buffers(), shape.layers);
        let storage = |name, bytes: u64, extra| Buffer::storage(gpu, name, bytes, extra);
        use vk::BufferUsageFlags as B;
        let [width, height] = lab.view().size.map(u64::from);
        let root = storage("root fit", size_of::<Fit>() as u64, B::empty())?;
        let drawn = storage("tiles drawn", 4 * u64::from(tiles), B::empty())?;
        let picked = storage("tile of each pixel", 4 * width * height, B::empty())?;
        let counts = storage("tile counts", size_of::<TileCounts>() as u64, B::INDIRECT_BUFFER)?;
        let list = storage("tile list", 4 * u64::from(tiles), B::empty())?;
        let items = storage("tile items", ITEM_BYTES * u64::from(ITEM_CAPACITY), B::empty())?;
        let pairs = storage("tile pairs", 2 * PAIR_BYTES * u64::from(PAIR_CAPACITY), B::empty())?;
        let commands = storage("tile draws", 2 * COMMAND_BYTES * u64::from(PAIR_CAPACITY), B::INDIRECT_BUFFER)?;
        let casters = [
            Binding::Uniform(light),
            Binding::Storage(fits),
            Binding::External(scene.instances),
            Binding::External(scene.meshes),
        ];
        let [list_at, counts_at, items_at] = [&list, &counts, &items].map(Binding::Storage);
        let side = (shape.side as f32).to_bits();
        let state = GraphicsState {
            positions: None,
            depth_compare: vk::CompareOp::ALWAYS,
            ..GraphicsState::casters(scene.position_layout, false)
        };
        let clear =
            Shaders { vertex: spirv!("methods/tile_clear.vert"), tessellation: None, fragment: None, constants: &[] };
        let (list_spirv, items_spirv) = (spirv!("methods/tile_list.comp"), spirv!("methods/tile_items.comp"));
        let pairs_spirv = spirv!("methods/tile_pairs.comp");
        let buffers = [&root, &drawn, &picked, &counts, &list, &items, &pairs, &commands];
        Ok(Self {
            bytes: buffers.iter().map(|buffer| buffer.size).sum(),
            list_pass: Compute::new(
                gpu,
                "tile_list",
                list_spirv,
                &[Binding::Storage(&drawn), list_at, counts_at],
                &[],
                4,
            )?,
            items_pass: Compute::new(
                gpu,
                "tile_items",
                items_spirv,
                &[&casters[..], &[list_at, counts_at, items_at]].concat(),
                &[side],
                4,
            )?,
            pairs_pass: Compute::new(
                gpu,
                "tile_pairs",
                pairs_spirv,
                &[
                    &casters[..],
                    &[
                        Binding::External(scene.clusters),
                        counts_at,
                        items_at,
                        Binding::Storage(&pairs),
                        Binding::Storage(&commands),
                    ],
                ]
                .concat(),
                &[side, 0, PAIR_CAPACITY],
                0,
            )?,
            clear: Graphics::new(gpu, "tile_clear", &clear, &[Binding::Storage(&drawn)], &state)?,
            root,
            drawn,
            picked,
            counts,
            _inner: [list, items],
            pairs,
            commands,
            instance_count: scene.instance_count,
            tiles,
            gpu: gpu.clone(),
        })
    }

    /// Before the first draw of a frame, among its transfers: nothing was dropped yet.
    pub(super) fn reset(&self, cmd: vk::CommandBuffer) {
        // SAFETY: the command buffer is recording; the map's own commands wait for the last frame and for this
        unsafe { self.gpu.device.cmd_fill_buffer(cmd, self.counts.raw, 0, vk::WHOLE_SIZE, 0) };
    }

    /// Finds what each tile that is drawn gets. Fits and marks were written by shaders; leaves draws for [`Self::draw`].
    pub(super) fn cull(&self, cmd: vk::CommandBuffer) {
        use Access::*;
        let device = &self.gpu.device;
        let next = || sync::barrier(device, cmd, &[(ComputeWrite, ComputeWrite), (ComputeWrite, IndirectRead)]);
        // draws of this frame before may still read
        sync::barrier(
            device,
            cmd,
            &[(ComputeWrite, ComputeWrite), (IndirectRead, ComputeWrite), (GraphicsRead, ComputeWrite)],
        );
        if !self.gpu.draw_indirect_count {
            // commands beyond the count draw nothing
            sync::barrier(device, cmd, &[(IndirectRead, TransferWrite)]);
            // SAFETY: the command buffer is recording
            unsafe { device.cmd_fill_buffer(cmd, self.commands.raw, 0, vk::WHOLE_SIZE, 0) };
            sync::barrier(device, cmd, &[(TransferWrite, ComputeWrite)]);
        }
        self.list_pass.dispatch(cmd, &self.instance_count, [1, 1, 1]);
        next();
        self.items_pass.dispatch_indirect(cmd, &self.instance_count, &self.counts, 0);
        next();
        self.pairs_pass.dispatch(cmd, &(), [GROUPS, 1, 1]);
        sync::barrier(
            device,
            cmd,
            &[(ComputeWrite, IndirectRead), (ComputeWrite, GraphicsRead), (ComputeWrite, ComputeRead)],
        );
    }

    /// Clears the layers whose tiles are drawn; inside rendering.
    fn clear(&self, cmd: vk::CommandBuffer) {
        self.clear.bind(cmd);
        // SAFETY: the command buffer is recording and the pipeline bound
        unsafe { self.gpu.device.cmd_draw(cmd, 3, self.tiles, 0, 0) };
    }

    /// Into the layers whose tiles are drawn, what was found; inside rendering. `pipelines`: for what is not alpha tested, and
    /// for what is.
    pub(super) fn draw(&self, cmd: vk::CommandBuffer, pipelines: [&Graphics; 2]) {
        self.clear(cmd);
        for (pipeline, masked) in pipelines.into_iter().zip([false, true]) {
            pipeline.bind(cmd);
            self.draw_found(cmd, masked);
        }
    }

    fn draw_found(&self, cmd: vk::CommandBuffer, masked: bool) {
        let device = &self.gpu.device;
        let offset = if masked { u64::from(PAIR_CAPACITY) * COMMAND_BYTES } else { 0 };
        let count = if masked { offset_of!(TileCounts, masked) } else { offset_of!(TileCounts, opaque) };
        let (commands, stride) = (self.commands.raw, COMMAND_BYTES as u32);
        // SAFETY: pipeline, set and vertex buffers are bound; commands and counts have indirect usage
        unsafe {
            if self.gpu.draw_indirect_count {
                let counts = self.counts.raw;
                device.cmd_draw_indexed_indirect_count(
                    cmd,
                    commands,
                    offset,
                    counts,
                    count as u64,
                    PAIR_CAPACITY,
                    stride,
                );
            } else {
                device.cmd_draw_indexed_indirect(cmd, commands, offset, PAIR_CAPACITY, stride);
            }
        }
    }

    /// Draws and runs of the last frame that there was no room for: casters may be missing where it is not 0.
    pub(super) fn dropped(&self, lab: &Lab) -> Result<u64, LabError> {
        let counts: TileCounts =
            bytemuck::pod_read_unaligned(&lab.read_buffer(&self.counts)?[..size_of::<TileCounts>()]);
        Ok(counts.dropped.into())
    }
}
