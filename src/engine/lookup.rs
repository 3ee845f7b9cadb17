//! The full-screen mask: visibility towards every light.
//! Reads: receivers, lights of each tile, page table, atlas, depth ranges. Writes: mask, and with exact
//! edges the rays of what the map cannot decide. At their capacity the map decides.

use super::buffers::Buffers;
use super::exact::Exact;
use super::view::ViewBuffers;
use crate::config::BEND;
#[cfg(feature = "lab")]
use crate::gpu::Image;
use crate::gpu::{Binding, Compute, Gpu, HostSet, spirv};
use crate::{Config, Error};
use ash::vk;
use std::sync::Arc;

/// For any lights, and for one sun.
pub(crate) struct Lookup([Compute; 2]);

impl Lookup {
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        config: &Config,
        b: &Buffers,
        (number, view): (usize, &ViewBuffers),
        exact: Option<&Exact>,
    ) -> Result<Self, Error> {
        let common = Self::common(b, number, view);
        let (tile_lights, ranges) = (Binding::Storage(&view.tile_lights), Binding::Storage(&b.ranges));
        let bindings = [&common[..6], &[Binding::StorageImage(&view.mask), common[6], tile_lights, ranges]].concat();
        // without rays these are not touched, but every binding must be filled
        let rays = exact.map_or([&b.nothing[number]; 3], |e| [&e.count, &e.items, &e.rays]).map(Binding::Storage);
        let bindings = [&bindings[..], &rays].concat();
        let [filter, taps] = config.filter.words();
        let [traces, capacity] = exact.map_or([0; 2], |exact| [1, exact.capacity]);
        let bend = BEND.to_bits();
        let pass = |sun| {
            let [blend, ranged] = [config.level_blend, config.filter.ranged()].map(u32::from);
            let (table, bits) = (config.table_size(), config.mask_bits);
            let constants =
                [table, config.gutter, bits, sun, filter, taps, blend, ranged, traces, capacity, config.samples, bend];
            Compute::new(gpu, "lookup", spirv!("engine/lookup.comp"), &bindings, &constants, 0)
        };
        Ok(Self([pass(0)?, pass(1)?]))
    }

    #[cfg(feature = "lab")]
    /// For debugging: the page table entry of every pixel for the first light, into an R32_UINT image.
    pub(crate) fn entries(
        gpu: &Arc<Gpu>,
        config: &Config,
        b: &Buffers,
        (number, view): (usize, &ViewBuffers),
        target: &Image,
    ) -> Result<Compute, Error> {
        let common = Self::common(b, number, view);
        let bindings = [&common[..6], &[Binding::StorageImage(target), common[6]]].concat();
        let constants = [config.table_size(), config.gutter];
        let words = spirv!("engine/lookup_entries.comp");
        Compute::new(gpu, "lookup_entries", words, &bindings, &constants, 0)
    }

    /// What every lookup reads; the last are the lights.
    pub(crate) fn common<'a>(b: &'a Buffers, number: usize, view: &'a ViewBuffers) -> [Binding<'a>; 7] {
        [
            b.frame(number),
            Binding::Sampled(&view.receivers.depth),
            Binding::Sampled(&view.receivers.planes),
            Binding::Storage(&b.table_keys),
            Binding::Storage(&b.entries),
            Binding::Sampled(&b.atlas),
            Binding::Storage(&b.lights),
        ]
    }

    /// What `glsl/host/umbrage.glsl` reads, for shaders of the host.
    pub(crate) fn host_set(gpu: &Arc<Gpu>, b: &Buffers, number: usize) -> Result<HostSet, Error> {
        use vk::ShaderStageFlags as S;
        let [keys, entries, lights, ranges] = [&b.table_keys, &b.entries, &b.lights, &b.ranges].map(Binding::Storage);
        let stages = S::VERTEX | S::FRAGMENT | S::COMPUTE;
        HostSet::new(
            gpu,
            "host lookup",
            stages,
            &[b.frame(number), keys, entries, Binding::Sampled(&b.atlas), lights, ranges],
        )
    }

    /// `sun`: the only light is directional, in slot 0.
    pub(crate) fn record(&self, cmd: vk::CommandBuffer, size: [u32; 2], sun: bool) {
        self.0[usize::from(sun)].dispatch(cmd, &(), [size[0].div_ceil(8), size[1].div_ceil(8), 1]);
    }
}
