//! Marks which pages the visible pixels need, at the finest level they may ask for.
//! Reads: receivers, lights. Writes: page table (flags route) or keys with pixel counts (sort route), and the
//! lights that reach each tile of 8x8 pixels.
//! At capacity: keeps counting; a coarser attempt follows, the last of which asks for root pages only.

use super::buffers::{Buffers, arguments};
use super::constants::ROOT_LEVEL;
use super::sort::Sort;
use super::view::ViewBuffers;
use crate::config::RequestRoute;
use crate::gpu::structs::{RequestPush, RetryPush};
use crate::gpu::{Binding, Compute, Gpu, spirv};
use crate::{Config, Error};
use ash::vk;
use std::sync::Arc;

/// Levels by which the attempts coarsen all requests.
pub(crate) const SHIFTS: [u32; 4] = [0, 2, 5, ROOT_LEVEL as u32];

pub(crate) struct Request {
    /// For any lights, and for one sun.
    request: [Compute; 2],
    retry: Compute,
    groups: [u32; 2],
}

impl Request {
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        config: &Config,
        b: &Buffers,
        (number, view): (usize, &ViewBuffers),
        sort: Option<&Sort>,
        size: [u32; 2],
    ) -> Result<Self, Error> {
        let flags = config.route == RequestRoute::Flags;
        let capacity = sort.map_or(config.request_capacity(), |sort| sort.capacity);
        // the flags route appends nothing; its pass still needs every binding filled
        let [keys, values] = sort.map_or([&b.chosen[0], &b.chosen[1]], |sort| [sort.keys(), sort.values()]);
        let constants = [config.table_size(), u32::from(flags), capacity];
        let bindings = [
            b.frame(number),
            Binding::Sampled(&view.receivers.depth),
            Binding::Sampled(&view.receivers.planes),
            Binding::Storage(&b.counters),
            Binding::Storage(&b.table_keys),
            Binding::Storage(&b.nodes),
            Binding::Storage(&b.node_list),
            Binding::Storage(keys),
            Binding::Storage(values),
            Binding::Storage(&b.lights),
            Binding::Storage(&view.tile_lights),
        ];
        let retry = [
            Binding::Storage(&b.counters),
            Binding::Storage(&b.table_keys),
            Binding::Storage(&b.nodes),
            Binding::Storage(&b.arguments),
        ];
        let request = |sun: u32| {
            let constants = [constants[0], constants[1], constants[2], sun, u32::from(config.level_blend)];
            let push = size_of::<RequestPush>();
            Compute::new(gpu, "request", spirv!("engine/request.comp"), &bindings, &constants, push)
        };
        Ok(Self {
            request: [request(0)?, request(1)?],
            retry: Compute::new(
                gpu,
                "request_retry",
                spirv!("engine/request_retry.comp"),
                &retry,
                &constants,
                size_of::<RetryPush>(),
            )?,
            groups: size.map(|side| side.div_ceil(8)),
        })
    }

    /// Attempt 0 runs always. `sun`: the only light is directional, in slot 0.
    pub(crate) fn record_first(&self, cmd: vk::CommandBuffer, sun: bool) {
        self.request[usize::from(sun)].dispatch(
            cmd,
            &RequestPush { attempt: 0, shift: SHIFTS[0] },
            [self.groups[0], self.groups[1], 1],
        );
    }

    /// Decides on the GPU whether attempt `next` must run; 4 follows the last and only takes stock. `size`: pixels that hold
    /// any view; all views of an attempt are dispatched alike.
    pub(crate) fn record_decision(&self, cmd: vk::CommandBuffer, next: usize, size: [u32; 2]) {
        let push = RetryPush {
            attempt: next as u32 - 1,
            shift: SHIFTS[next.min(3)],
            groups_x: size[0].div_ceil(8),
            groups_y: size[1].div_ceil(8),
            argument: arguments::RETRY[next - 1],
        };
        self.retry.dispatch(cmd, &push, [16, 1, 1]);
    }

    /// Attempt `next`, 1 to 3; an empty dispatch when the one before sufficed.
    pub(crate) fn record_retry(&self, cmd: vk::CommandBuffer, b: &Buffers, next: usize, sun: bool) {
        let push = RequestPush { attempt: next as u32, shift: SHIFTS[next] };
        let offset = 4 * u64::from(arguments::RETRY[next - 1]);
        self.request[usize::from(sun)].dispatch_indirect(cmd, &push, &b.arguments, offset);
    }
}
