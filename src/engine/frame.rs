//! The timeline of a frame: every pass in order and every barrier between passes.

use super::Engine;
use super::query::RayQuery;
use crate::gpu::Timer;
use crate::gpu::structs::{Counters, Frame, LightRecord, frame_flags, light_kind};
use crate::gpu::sync::{self, Access::*};
use ash::vk;

/// Most bytes that one command writes into a buffer.
const UPDATE: usize = 65536;

/// What the CPU knows of a frame; its lists are kept from frame to frame and never grow.
#[derive(Default)]
pub(super) struct FrameData {
    /// For each view.
    pub(super) constants: Vec<Frame>,
    /// For each view, which of its images.
    pub(super) images: Vec<usize>,
    /// For each slot of each view.
    pub(super) lights: Vec<LightRecord>,
}

impl FrameData {
    pub(super) fn with_room(views: usize, lights: usize) -> Self {
        Self {
            constants: Vec::with_capacity(views),
            images: Vec::with_capacity(views),
            lights: Vec::with_capacity(views * lights),
        }
    }
}

impl Engine {
    /// Writes what the CPU knows of a frame.
    pub(super) fn upload(&self, cmd: vk::CommandBuffer, data: &FrameData) {
        let (device, b) = (&self.gpu.device, &self.buffers);
        // SAFETY: the command buffer is recording; the constants are smaller than 64 KiB
        unsafe {
            for (frame, constants) in b.frames.iter().zip(&data.constants) {
                device.cmd_update_buffer(cmd, frame.raw, 0, bytemuck::bytes_of(constants));
            }
            let records: &[u8] = bytemuck::cast_slice(&data.lights);
            for (i, part) in records.chunks(UPDATE).enumerate() {
                device.cmd_update_buffer(cmd, b.lights.raw, (i * UPDATE) as u64, part);
            }
        }
    }

    /// Records one frame. Commands do not depend on what the GPU finds. `draw`: records the casters that the host draws.
    pub(super) fn record_timeline(
        &self,
        cmd: vk::CommandBuffer,
        data: &FrameData,
        draw: Option<&mut dyn FnMut(vk::CommandBuffer)>,
        mut timer: Option<&mut Timer>,
    ) {
        let constants = &data.constants[0];
        let sun = data.constants.iter().all(|c| c.lights[0] == 1 && c.sun.kind[0] == light_kind::DIRECTIONAL);
        let draws = self.steering.pages(constants.cache[0] & frame_flags::LIGHT_MOVED != 0);
        let device = &self.gpu.device;
        let b = &self.buffers;
        let size = self.config.size;
        let next = || sync::barrier(device, cmd, &[(ComputeWrite, ComputeWrite)]);
        let mut stage = |name: &'static str| {
            if let Some(timer) = &mut timer {
                timer.mark(cmd, name);
            }
        };
        self.gpu.begin_label(cmd, c"umbrage");

        // what the last frame read or wrote is reset; the buffers need no copies because the GPU runs frames in order
        sync::barrier(
            device,
            cmd,
            &[
                (ComputeWrite, TransferWrite),
                (GraphicsRead, TransferWrite),
                (IndirectRead, TransferWrite),
                (TransferRead, TransferWrite),
                (GraphicsRead, ComputeWrite),
                (IndirectRead, ComputeWrite),
            ],
        );
        self.upload(cmd, data);
        // SAFETY: the command buffer is recording
        unsafe {
            for buffer in [&b.counters, &b.table_keys, &b.entries, &b.nodes, &b.histogram, &b.roots] {
                device.cmd_fill_buffer(cmd, buffer.raw, 0, vk::WHOLE_SIZE, 0);
            }
            if let Some(compact) = &self.compact {
                device.cmd_fill_buffer(cmd, compact.counts.raw, 0, vk::WHOLE_SIZE, 0);
            }
            if !self.gpu.draw_indirect_count {
                device.cmd_fill_buffer(cmd, b.commands.raw, 0, vk::WHOLE_SIZE, 0);
            }
            if let Some(bvh) = &self.bvh {
                bvh.record_reset(cmd);
                device.cmd_fill_buffer(cmd, bvh.changes.raw, 0, 4, 0);
            }
            for exact in self.views.iter().filter_map(|view| view.exact.as_ref()) {
                device.cmd_fill_buffer(cmd, exact.count.raw, 0, vk::WHOLE_SIZE, 0);
            }
        }
        sync::barrier(
            device,
            cmd,
            &[(TransferWrite, ComputeWrite), (TransferWrite, ComputeRead), (TransferWrite, GraphicsRead)],
        );
        for view in &self.views {
            view.buffers.receivers.record_discard(device, cmd);
            sync::mask(device, cmd, &view.buffers.mask, &view.mask_use, false);
        }
        stage("reset");

        for (view, &images) in self.views.iter().zip(&data.images) {
            view.record_gradient(device, cmd, images);
        }
        stage("gradient");

        for view in &self.views {
            view.request.record_first(cmd, sun);
        }
        for attempt in 1..=3 {
            next();
            self.views[0].request.record_decision(cmd, attempt, size);
            sync::barrier(device, cmd, &[(ComputeWrite, ComputeWrite), (ComputeWrite, IndirectRead)]);
            for view in &self.views {
                view.request.record_retry(cmd, b, attempt, sun);
            }
        }
        next();
        self.views[0].request.record_decision(cmd, 4, size);
        next();
        stage("request");

        if let (Some(sort), Some(compact)) = (&self.sort, &self.compact) {
            sync::barrier(device, cmd, &[(IndirectRead, ComputeWrite)]);
            sort.record(cmd, b);
            stage("sort");
            compact.record(cmd, b);
            next();
            stage("compact");
        }

        sync::barrier(device, cmd, &[(IndirectRead, ComputeWrite)]);
        self.allocate.record_tree(cmd);
        next();
        self.cache.record_track(cmd);
        next();
        self.cache.record_invalidate(cmd);
        next();
        self.cull.record_touch(cmd, b);
        next();
        self.cache.record_adopt(cmd);
        next();
        stage("cache");

        if let Some(bvh) = &self.bvh {
            sync::barrier(device, cmd, &[(IndirectRead, ComputeWrite)]);
            bvh.record(cmd);
            stage("bvh");
        }
        let queries = self.views.iter().filter_map(|view| view.exact.as_ref()?.query.as_ref());
        if queries.clone().next().is_some() {
            RayQuery::record(device, cmd, queries);
            stage("query");
        }

        self.allocate.record_pages(cmd, draws);
        next();
        stage("allocate");

        sync::barrier(device, cmd, &[(IndirectRead, ComputeWrite)]);
        self.cull.record_admission(cmd, b);
        next();
        self.cache.record_assign(cmd);
        sync::barrier(device, cmd, &[(ComputeWrite, ComputeWrite), (ComputeWrite, IndirectRead)]);
        // entries and pairs are independent; pairs dominate
        self.allocate.record_entries(cmd);
        self.cull.record_pairs(cmd, b);
        sync::barrier(
            device,
            cmd,
            &[(ComputeWrite, ComputeWrite), (IndexRead, ComputeWrite), (IndirectRead, ComputeWrite)],
        );
        self.cull.record_triangles(cmd, b);
        sync::barrier(
            device,
            cmd,
            &[
                (ComputeWrite, IndirectRead),
                (ComputeWrite, IndexRead),
                (ComputeWrite, GraphicsRead),
                (ComputeWrite, ComputeRead),
                (ComputeWrite, TransferRead),
            ],
        );
        stage("cull");

        if constants.cache[0] & frame_flags::FORGET_PAGES != 0 {
            sync::discard(device, cmd, &b.atlas, LookupRead, DepthAttachment);
        } else {
            sync::image(device, cmd, &b.atlas, LookupRead, DepthAttachment);
        }
        self.tiles.record(cmd, b, draw);
        sync::image(device, cmd, &b.atlas, DepthAttachment, LookupRead);
        if self.tiles.record_ranges(cmd, b) {
            sync::barrier(device, cmd, &[(ComputeWrite, LookupRead)]);
        }
        stage("tiles");

        for view in &self.views {
            view.lookup.record(cmd, view.size, sun);
        }
        stage("lookup");

        if self.config.exact {
            next();
            for exact in self.views.iter().filter_map(|view| view.exact.as_ref()) {
                exact.record(cmd);
            }
            stage("exact");
        }
        for view in &self.views {
            sync::mask(device, cmd, &view.buffers.mask, &view.mask_use, true);
        }

        let size = size_of::<Counters>() as u64;
        let copy = [vk::BufferCopy { src_offset: 0, dst_offset: self.readback_offset(self.recorded), size }];
        sync::barrier(device, cmd, &[(HostRead, TransferWrite), (TransferWrite, TransferWrite)]);
        // SAFETY: both buffers hold the counters
        unsafe { device.cmd_copy_buffer(cmd, b.counters.raw, b.readback.raw, &copy) };
        sync::barrier(device, cmd, &[(TransferWrite, HostRead)]);
        self.gpu.end_label(cmd);
    }
}
