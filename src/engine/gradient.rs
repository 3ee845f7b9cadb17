//! The receiver's plane of every pixel: geometric normal and world-space derivatives per pixel.
//! Reads: depth, normal. Writes: receiver planes (16 bytes a pixel). No capacity.

use crate::Error;
use crate::gpu::{Binding, Compute, Gpu, spirv};
use crate::host::Receivers;
use ash::vk;
use std::sync::Arc;

pub(crate) struct Gradient(Compute);

impl Gradient {
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        frame: Binding<'_>,
        receivers: &Receivers,
        receiver: Binding<'_>,
    ) -> Result<Self, Error> {
        let bindings = [frame, Binding::SampledView(receivers.depth), Binding::SampledView(receivers.normal), receiver];
        Ok(Self(Compute::new(gpu, "gradient", spirv!("engine/gradient.comp"), &bindings, &[], 0)?))
    }

    pub(crate) fn record(&self, cmd: vk::CommandBuffer, size: [u32; 2]) {
        self.0.dispatch(cmd, &(), [size[0].div_ceil(8), size[1].div_ceil(8), 1]);
    }
}
