//! The page of every pixel and the state of every layer after a frame, left on the device for debug views.

use super::PageViews;
use crate::engine::Engine;
use crate::engine::buffers::arguments;
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Buffer, Compute, spirv};
use crate::lab::{Lab, LabError};
use ash::vk;

/// Passes and results; made when first asked for.
pub(super) struct RmsmPages {
    states: Buffer,
    pages: Buffer,
    layers: Compute,
    serving: Compute,
}

impl RmsmPages {
    pub(super) fn new(engine: &Engine, lab: &Lab) -> Result<Self, LabError> {
        let (gpu, config, b) = (lab.gpu(), &engine.config, &engine.buffers);
        let view = &engine.views[0];
        let capacity = config.page_capacity();
        let words = |name, count: u64| Buffer::storage(gpu, name, 4 * count, vk::BufferUsageFlags::empty());
        let states = words("states of layers", u64::from(capacity))?;
        let pages = words("pages of pixels", u64::from(view.size[0]) * u64::from(view.size[1]))?;
        let [slots, cleared, arguments_of] = [&b.slots, &b.cleared, &b.arguments].map(Binding::Storage);
        let layers = [b.frame(0), slots, cleared, arguments_of, Binding::Storage(&states)];
        let serving = [
            b.frame(0),
            Binding::Sampled(&view.buffers.receivers.depth),
            Binding::Sampled(&view.buffers.receivers.planes),
            Binding::Storage(&b.table_keys),
            Binding::Storage(&b.entries),
            Binding::Sampled(&b.atlas),
            Binding::Storage(&b.lights),
            Binding::Storage(&states),
            Binding::Storage(&pages),
        ];
        let tolerance = (-config.level_bias).ceil().max(0.0) as u32;
        let of_pixels = [config.table_size(), config.gutter, tolerance];
        let (layers_code, pages_code) = (spirv!("methods/rmsm_layers.comp"), spirv!("methods/rmsm_pages.comp"));
        let of_layers = [capacity, arguments::CLEAR];
        Ok(Self {
            layers: Compute::new(gpu, "rmsm_layers", layers_code, &layers, &of_layers, 0)?,
            serving: Compute::new(gpu, "rmsm_pages", pages_code, &serving, &of_pixels, 0)?,
            states,
            pages,
        })
    }

    /// Brings the results to the last frame.
    pub(super) fn update(&self, engine: &Engine, lab: &Lab) -> Result<(), LabError> {
        let device = &lab.gpu().device;
        let [width, height] = engine.views[0].size;
        lab.submit(|cmd| {
            sync::barrier(device, cmd, &[(Access::ComputeWrite, Access::ComputeWrite)]);
            self.layers.dispatch(cmd, &(), [engine.config.page_capacity().div_ceil(64), 1, 1]);
            sync::barrier(device, cmd, &[(Access::ComputeWrite, Access::ComputeRead)]);
            self.serving.dispatch(cmd, &(), [width.div_ceil(8), height.div_ceil(8), 1]);
        })?;
        Ok(())
    }

    pub(super) fn views<'a>(&'a self, engine: &'a Engine) -> PageViews<'a> {
        PageViews {
            pages: &self.pages,
            states: &self.states,
            layers: &engine.buffers.slots,
            atlas: &engine.buffers.atlas,
        }
    }
}
