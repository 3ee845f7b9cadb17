//! The full-screen mask.
//! Reads: depth, receiver planes, page table, atlas. Writes: visibility. No capacity.

use super::buffers::Buffers;
use crate::gpu::{Binding, Compute, Gpu, Image, spirv};
use crate::host::Receivers;
use crate::{Config, Error};
use ash::vk;
use std::sync::Arc;

pub(crate) struct Lookup(Compute);

impl Lookup {
    pub(crate) fn new(gpu: &Arc<Gpu>, config: &Config, b: &Buffers, receivers: &Receivers) -> Result<Self, Error> {
        Self::with(gpu, "lookup", spirv!("engine/lookup.comp"), config, b, receivers, &b.visibility)
    }

    #[cfg(feature = "lab")]
    /// For debugging: the page table entry of every pixel instead of its visibility, into an R32_UINT image.
    pub(crate) fn entries(
        gpu: &Arc<Gpu>,
        config: &Config,
        b: &Buffers,
        receivers: &Receivers,
        target: &Image,
    ) -> Result<Self, Error> {
        Self::with(gpu, "lookup_entries", spirv!("engine/lookup_entries.comp"), config, b, receivers, target)
    }

    fn with(
        gpu: &Arc<Gpu>,
        name: &'static str,
        words: &[u8],
        config: &Config,
        b: &Buffers,
        receivers: &Receivers,
        target: &Image,
    ) -> Result<Self, Error> {
        let bindings = [
            Binding::Uniform(&b.frame),
            Binding::SampledView(receivers.depth),
            Binding::Sampled(&b.receiver),
            Binding::Storage(&b.table_keys),
            Binding::Storage(&b.entries),
            Binding::Sampled(&b.atlas),
            Binding::StorageImage(target),
        ];
        Ok(Self(Compute::new(gpu, name, words, &bindings, &[config.table_size(), config.gutter], 0)?))
    }

    pub(crate) fn record(&self, cmd: vk::CommandBuffer, size: [u32; 2]) {
        self.0.dispatch(cmd, &(), [size[0].div_ceil(8), size[1].div_ceil(8), 1]);
    }
}
