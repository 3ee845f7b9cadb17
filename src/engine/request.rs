//! Marks which pages the visible pixels need, at the finest level they may ask for.
//! Reads: depth, receiver planes. Writes: page table (flags route) or keys with pixel counts (sort route).
//! At capacity: keeps counting; a coarser attempt follows, the last of which asks for root pages only.

use super::buffers::{Buffers, arguments};
use super::constants::ROOT_LEVEL;
use super::sort::Sort;
use crate::config::RequestRoute;
use crate::gpu::structs::{RequestPush, RetryPush};
use crate::gpu::{Binding, Compute, Gpu, spirv};
use crate::host::Receivers;
use crate::{Config, Error};
use ash::vk;
use std::sync::Arc;

/// Levels by which the attempts coarsen all requests.
pub(crate) const SHIFTS: [u32; 4] = [0, 2, 5, ROOT_LEVEL as u32];

pub(crate) struct Request {
    request: Compute,
    retry: Compute,
    groups: [u32; 2],
}

impl Request {
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        config: &Config,
        b: &Buffers,
        sort: &Sort,
        receivers: &Receivers,
    ) -> Result<Self, Error> {
        let flags = config.route == RequestRoute::Flags;
        let capacity = if flags { config.request_capacity() } else { sort.capacity };
        let constants = [config.table_size(), u32::from(flags), capacity];
        let bindings = [
            Binding::Uniform(&b.frame),
            Binding::SampledView(receivers.depth),
            Binding::Sampled(&b.receiver),
            Binding::Storage(&b.counters),
            Binding::Storage(&b.table_keys),
            Binding::Storage(&b.nodes),
            Binding::Storage(&b.node_list),
            Binding::Storage(sort.keys()),
            Binding::Storage(sort.values()),
        ];
        let retry = [
            Binding::Storage(&b.counters),
            Binding::Storage(&b.table_keys),
            Binding::Storage(&b.nodes),
            Binding::Storage(&b.arguments),
        ];
        Ok(Self {
            request: Compute::new(
                gpu,
                "request",
                spirv!("engine/request.comp"),
                &bindings,
                &constants,
                size_of::<RequestPush>(),
            )?,
            retry: Compute::new(
                gpu,
                "request_retry",
                spirv!("engine/request_retry.comp"),
                &retry,
                &constants,
                size_of::<RetryPush>(),
            )?,
            groups: [config.size[0].div_ceil(8), config.size[1].div_ceil(8)],
        })
    }

    /// Attempt 0 runs always.
    pub(crate) fn record_first(&self, cmd: vk::CommandBuffer) {
        self.request.dispatch(cmd, &RequestPush { attempt: 0, shift: SHIFTS[0] }, [self.groups[0], self.groups[1], 1]);
    }

    /// Decides on the GPU whether attempt `next` must run; 4 follows the last and only takes stock.
    pub(crate) fn record_decision(&self, cmd: vk::CommandBuffer, next: usize) {
        let push = RetryPush {
            attempt: next as u32 - 1,
            shift: SHIFTS[next.min(3)],
            groups_x: self.groups[0],
            groups_y: self.groups[1],
            argument: arguments::RETRY[next - 1],
        };
        self.retry.dispatch(cmd, &push, [16, 1, 1]);
    }

    /// Attempt `next`, 1 to 3; an empty dispatch when the one before sufficed.
    pub(crate) fn record_retry(&self, cmd: vk::CommandBuffer, b: &Buffers, next: usize) {
        let push = RequestPush { attempt: next as u32, shift: SHIFTS[next] };
        self.request.dispatch_indirect(cmd, &push, &b.arguments, 4 * u64::from(arguments::RETRY[next - 1]));
    }
}
