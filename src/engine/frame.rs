//! The timeline of a frame: every pass in order and every barrier between passes.

use super::Engine;
use crate::gpu::structs::{Counters, frame_flags};
use crate::gpu::sync::{self, Access::*};
use crate::gpu::{Timer, structs::Frame};
use ash::vk;

impl Engine {
    /// Records one frame. Commands do not depend on what the GPU finds.
    pub(super) fn record_timeline(&self, cmd: vk::CommandBuffer, constants: &Frame, mut timer: Option<&mut Timer>) {
        // the first frame of all is not one in which the light turned
        let turned = constants.cache[0] & (frame_flags::LIGHT_MOVED | frame_flags::FORGET_PAGES);
        let draws = self.steering.pages(turned == frame_flags::LIGHT_MOVED);
        let device = &self.gpu.device;
        let b = &self.buffers;
        let size = self.config.size;
        let next = || sync::barrier(device, cmd, &[(ComputeWrite, ComputeWrite)]);
        let mut stage = |name: &'static str| {
            self.gpu.end_label(cmd);
            self.gpu.begin_label(cmd, "umbrage");
            if let Some(timer) = &mut timer {
                timer.mark(cmd, name);
            }
        };
        self.gpu.begin_label(cmd, "umbrage");

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
        // SAFETY: the command buffer is recording; the constants are smaller than 64 KiB
        unsafe {
            device.cmd_update_buffer(cmd, b.frame.raw, 0, bytemuck::bytes_of(constants));
            for buffer in [&b.counters, &b.table_keys, &b.entries, &b.nodes, &b.histogram] {
                device.cmd_fill_buffer(cmd, buffer.raw, 0, vk::WHOLE_SIZE, 0);
            }
            if let Some(compact) = &self.compact {
                device.cmd_fill_buffer(cmd, compact.counts.raw, 0, vk::WHOLE_SIZE, 0);
            }
            if !self.gpu.draw_indirect_count {
                device.cmd_fill_buffer(cmd, b.commands.raw, 0, vk::WHOLE_SIZE, 0);
            }
        }
        sync::barrier(
            device,
            cmd,
            &[(TransferWrite, ComputeWrite), (TransferWrite, ComputeRead), (TransferWrite, GraphicsRead)],
        );
        sync::discard(device, cmd, &b.receiver, ComputeRead, StorageImage);
        sync::discard(device, cmd, &b.visibility, TransferRead, StorageImage);
        stage("reset");

        self.gradient.record(cmd, size);
        sync::image(device, cmd, &b.receiver, StorageImage, ComputeRead);
        stage("gradient");

        self.request.record_first(cmd);
        for attempt in 1..=3 {
            next();
            self.request.record_decision(cmd, attempt);
            sync::barrier(device, cmd, &[(ComputeWrite, ComputeWrite), (ComputeWrite, IndirectRead)]);
            self.request.record_retry(cmd, b, attempt);
        }
        next();
        self.request.record_decision(cmd, 4);
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

        self.allocate.record_pages(cmd, b, &self.page_sort, draws);
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
            sync::discard(device, cmd, &b.atlas, ComputeRead, DepthAttachment);
        } else {
            sync::image(device, cmd, &b.atlas, ComputeRead, DepthAttachment);
        }
        self.tiles.record(cmd, b);
        sync::image(device, cmd, &b.atlas, DepthAttachment, ComputeRead);
        stage("tiles");

        self.lookup.record(cmd, size);
        sync::image(device, cmd, &b.visibility, StorageImage, TransferRead);
        stage("lookup");

        let copy = [vk::BufferCopy { src_offset: 0, dst_offset: 0, size: size_of::<Counters>() as u64 }];
        sync::barrier(device, cmd, &[(HostRead, TransferWrite), (TransferWrite, TransferWrite)]);
        // SAFETY: both buffers hold the counters
        unsafe { device.cmd_copy_buffer(cmd, b.counters.raw, b.readback.raw, &copy) };
        sync::barrier(device, cmd, &[(TransferWrite, HostRead)]);
        self.gpu.end_label(cmd);
    }
}
