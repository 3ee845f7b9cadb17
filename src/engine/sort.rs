//! Radix sort of 64-bit keys with a 32-bit value each: sixteen stable passes over 4-bit digits, without subgroups.
//! Reads and writes: keys, values. The number of entries comes from the counters; at capacity the rest is not sorted.

use super::buffers::{Buffers, arguments};
use crate::Error;
use crate::gpu::structs::PreparePush;
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Buffer, Compute, Gpu, spirv};
use ash::vk;
use std::sync::Arc;

/// Entries a workgroup handles.
pub(crate) const BLOCK: u32 = 512;
const DIGITS: u32 = 16;

pub(crate) struct Sort {
    pub(crate) capacity: u32,
    keys: [Buffer; 2],
    values: [Buffer; 2],
    histogram: Buffer,
    prepare: Compute,
    count: [Compute; 2],
    scan: Compute,
    scatter: [Compute; 2],
    device: ash::Device,
}

impl Sort {
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        counters: &Buffer,
        argument_buffer: &Buffer,
        capacity: u32,
    ) -> Result<Self, Error> {
        let make = |name: &str, bytes: u64| {
            Buffer::storage(gpu, name, bytes * u64::from(capacity), vk::BufferUsageFlags::empty())
        };
        let keys = [make("sort keys 0", 8)?, make("sort keys 1", 8)?];
        let values = [make("sort values 0", 4)?, make("sort values 1", 4)?];
        let blocks = u64::from(capacity.div_ceil(BLOCK));
        let histogram = Buffer::storage(gpu, "sort histogram", 4 * 16 * blocks, vk::BufferUsageFlags::empty())?;
        let constants = [BLOCK];
        let c = Binding::Storage(counters);
        let count = |i: usize| {
            let bindings = [c, Binding::Storage(&keys[i]), Binding::Storage(&histogram)];
            Compute::new(gpu, "sort_count", spirv!("engine/sort_count.comp"), &bindings, &constants, 4)
        };
        let scatter = |i: usize| {
            let bindings = [
                c,
                Binding::Storage(&keys[i]),
                Binding::Storage(&values[i]),
                Binding::Storage(&histogram),
                Binding::Storage(&keys[1 - i]),
                Binding::Storage(&values[1 - i]),
            ];
            Compute::new(gpu, "sort_scatter", spirv!("engine/sort_scatter.comp"), &bindings, &constants, 4)
        };
        let (count, scatter) = ([count(0)?, count(1)?], [scatter(0)?, scatter(1)?]);
        Ok(Self {
            prepare: Compute::new(
                gpu,
                "sort_prepare",
                spirv!("engine/sort_prepare.comp"),
                &[c, Binding::Storage(argument_buffer)],
                &constants,
                size_of::<PreparePush>(),
            )?,
            scan: Compute::new(
                gpu,
                "sort_scan",
                spirv!("engine/sort_scan.comp"),
                &[c, Binding::Storage(&histogram)],
                &constants,
                4,
            )?,
            count,
            scatter,
            capacity,
            keys,
            values,
            histogram,
            device: gpu.device.clone(),
        })
    }

    /// Keys before and after sorting.
    pub(crate) fn keys(&self) -> &Buffer {
        &self.keys[0]
    }

    /// Values before and after sorting.
    pub(crate) fn values(&self) -> &Buffer {
        &self.values[0]
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.keys.iter().chain(&self.values).map(|b| b.size).sum::<u64>() + self.histogram.size
    }

    /// Sorts; the caller has ordered the writes of keys, values and counters before compute reads.
    pub(crate) fn record(&self, cmd: vk::CommandBuffer, b: &Buffers) {
        use Access::*;
        let offset = 4 * u64::from(arguments::SORT);
        let push = PreparePush { capacity: self.capacity, argument: arguments::SORT };
        self.prepare.dispatch(cmd, &push, [1, 1, 1]);
        sync::barrier(&self.device, cmd, &[(ComputeWrite, ComputeWrite), (ComputeWrite, IndirectRead)]);
        for digit in 0..DIGITS {
            let side = (digit % 2) as usize;
            self.count[side].dispatch_indirect(cmd, &(4 * digit), &b.arguments, offset);
            sync::barrier(&self.device, cmd, &[(ComputeWrite, ComputeWrite)]);
            self.scan.dispatch(cmd, &16u32, [1, 1, 1]);
            sync::barrier(&self.device, cmd, &[(ComputeWrite, ComputeWrite)]);
            self.scatter[side].dispatch_indirect(cmd, &(4 * digit), &b.arguments, offset);
            sync::barrier(&self.device, cmd, &[(ComputeWrite, ComputeWrite)]);
        }
    }
}
