//! The full-screen mask.
//! Reads: depth, receiver planes, page table, atlas. Writes: visibility. No capacity.

use super::buffers::Buffers;
use crate::gpu::{Binding, Compute, Gpu, spirv};
use crate::host::Receivers;
use crate::{Config, Error};
use ash::vk;
use std::sync::Arc;

pub(crate) struct Lookup(Compute);

impl Lookup {
    pub(crate) fn new(gpu: &Arc<Gpu>, config: &Config, b: &Buffers, receivers: &Receivers) -> Result<Self, Error> {
        let bindings = [
            Binding::Uniform(&b.frame),
            Binding::SampledView(receivers.depth),
            Binding::Sampled(&b.receiver),
            Binding::Storage(&b.table_keys),
            Binding::Storage(&b.entries),
            Binding::Sampled(&b.atlas),
            Binding::StorageImage(&b.visibility),
        ];
        let constants = [config.table_size(), config.gutter];
        Ok(Self(Compute::new(gpu, "lookup", spirv!("engine/lookup.comp"), &bindings, &constants, 0)?))
    }

    pub(crate) fn record(&self, cmd: vk::CommandBuffer, size: [u32; 2]) {
        self.0.dispatch(cmd, &(), [size[0].div_ceil(8), size[1].div_ceil(8), 1]);
    }
}
