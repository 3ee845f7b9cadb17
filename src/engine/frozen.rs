//! A frame that only looks at the pages of the frame before: nothing is requested, chosen or drawn. For debugging.

use super::Engine;
use super::constants::{self, History};
use crate::gpu::Timer;
use crate::gpu::structs::{Counters, light_kind};
use crate::gpu::sync::{self, Access::*};
use crate::host::FrameInput;
use crate::{Error, engine::frame::FrameData};
use ash::vk;
use bytemuck::Zeroable;
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
        let lights = self.lights.records(&self.config, &self.scene, input, &last)?;
        let view = &self.views[0];
        let mut constants = constants::constants(&self.config, view.size, &self.scene, input, &last);
        constants.lights = [lights.len() as u32, u32::from(self.lights.any_local()), 0, 0];
        constants.sun = lights.first().copied().unwrap_or(Zeroable::zeroed());
        let sun = constants.lights[0] == 1 && constants.sun.kind[0] == light_kind::DIRECTIONAL;
        let (device, b) = (&self.gpu.device, &self.buffers);

        sync::barrier(
            device,
            cmd,
            &[(ComputeWrite, TransferWrite), (GraphicsRead, TransferWrite), (TransferRead, TransferWrite)],
        );
        let requests = offset_of!(Counters, requests) as u64;
        self.upload(cmd, &FrameData { constants: vec![constants], lights });
        // SAFETY: the command buffer is recording; both buffers hold the word
        unsafe {
            device.cmd_fill_buffer(cmd, b.counters.raw, requests, 4, FULL);
            if let Some(exact) = &view.exact {
                device.cmd_fill_buffer(cmd, exact.count.raw, 0, vk::WHOLE_SIZE, 0);
            }
        }
        sync::barrier(device, cmd, &[(TransferWrite, ComputeWrite), (TransferWrite, ComputeRead)]);
        sync::discard(device, cmd, &view.buffers.receiver, ComputeRead, StorageImage);
        sync::discard(device, cmd, &view.buffers.mask, TransferRead, StorageImage);
        view.gradient.record(cmd, view.size);
        sync::image(device, cmd, &view.buffers.receiver, StorageImage, ComputeRead);
        timer.mark(cmd, "gradient");
        // the structure is relative to the eye
        if let Some(query) = view.exact.as_ref().and_then(|exact| exact.query.as_ref()) {
            sync::barrier(device, cmd, &[(StructureBuild, ComputeWrite)]);
            query.record_instances(cmd);
            sync::barrier(device, cmd, &[(ComputeWrite, StructureBuild), (StructureRead, StructureBuild)]);
            query.record_build(cmd);
            sync::barrier(device, cmd, &[(StructureBuild, StructureRead)]);
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
        sync::image(device, cmd, &view.buffers.mask, StorageImage, TransferRead);
        Ok(())
    }
}
