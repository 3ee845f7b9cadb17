//! A frame that only looks at the pages of the frame before: nothing is requested, chosen or drawn. For debugging.

use super::Engine;
use super::constants::History;
use super::query::RayQuery;
use crate::gpu::Timer;
use crate::gpu::structs::{Counters, light_kind};
use crate::gpu::sync::{self, Access::*};
use crate::host::FrameInput;
use crate::{Error, engine::frame::FrameData};
use ash::vk;
use std::mem::offset_of;

/// More requests than any table holds: an attempt that stands at these asks for nothing and only finds the lights of each
/// tile. Half the range, so that counting on does not wrap.
const FULL: u32 = 1 << 31;

impl Engine {
    /// Records gradient and lookup of the first view with another camera; lights and casters must be those of the last
    /// frame. The mask is left as by [`Engine::record`].
    ///
    /// # Errors
    /// [`Error::Limit`] before the first frame.
    pub(crate) fn record_frozen(
        &self,
        cmd: vk::CommandBuffer,
        input: &FrameInput,
        timer: &mut Timer,
    ) -> Result<(), Error> {
        if self.history.frame == 0 {
            return Err(Error::Limit { field: "frames", given: "0".into(), limit: "1 or more".into() });
        }
        let last = History { flags: 0, ..self.history };
        let mut data = FrameData::default();
        self.fill(&mut data, std::slice::from_ref(input), &last)?;
        self.finish(&mut data, 0);
        let sun = data.lights.len() == 1 && data.lights[0].kind[0] == light_kind::DIRECTIONAL;
        let view = &self.views[0];
        view.check_images(input.images)?;
        let (device, b) = (&self.gpu.device, &self.buffers);

        sync::barrier(
            device,
            cmd,
            &[(ComputeWrite, TransferWrite), (GraphicsRead, TransferWrite), (TransferRead, TransferWrite)],
        );
        let requests = offset_of!(Counters, requests) as u64;
        self.upload(cmd, &data);
        // SAFETY: the command buffer is recording; both buffers hold the word
        unsafe {
            device.cmd_fill_buffer(cmd, b.counters.raw, requests, 4, FULL);
            if let Some(exact) = &view.exact {
                device.cmd_fill_buffer(cmd, exact.count.raw, 0, vk::WHOLE_SIZE, 0);
            }
        }
        sync::barrier(device, cmd, &[(TransferWrite, ComputeWrite), (TransferWrite, ComputeRead)]);
        view.buffers.receivers.record_discard(device, cmd);
        sync::mask(device, cmd, &view.buffers.mask, &view.mask_use, false);
        view.record_gradient(device, cmd, input.images);
        timer.mark(cmd, "gradient");
        // the structure is relative to the eye
        if let Some(query) = view.exact.as_ref().and_then(|exact| exact.query.as_ref()) {
            RayQuery::record(device, cmd, std::iter::once(query));
            timer.mark(cmd, "query");
        }
        if !sun {
            view.request.record_first(cmd, sun);
            sync::barrier(device, cmd, &[(ComputeWrite, ComputeWrite)]);
            timer.mark(cmd, "request");
        }
        view.lookup.record(cmd, view.size, sun);
        timer.mark(cmd, "lookup");
        if let Some(exact) = &view.exact {
            sync::barrier(device, cmd, &[(ComputeWrite, ComputeWrite)]);
            exact.record(cmd);
            timer.mark(cmd, "exact");
        }
        sync::mask(device, cmd, &view.buffers.mask, &view.mask_use, true);
        Ok(())
    }
}
