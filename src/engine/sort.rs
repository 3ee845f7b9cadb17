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

/// The buffers that a sort goes through, from the first of each pair to the second and back, and its passes.
pub(crate) struct Passes {
    pub(crate) keys: [Buffer; 2],
    pub(crate) values: [Buffer; 2],
    histogram: Buffer,
    count: [Compute; 2],
    scan: Compute,
    scatter: [Compute; 2],
    device: ash::Device,
}

impl Passes {
    /// For at most `capacity` entries, as many as `sorted` of the counters says.
    pub(crate) fn new(gpu: &Arc<Gpu>, counters: &Buffer, capacity: u32) -> Result<Self, Error> {
        let make = |name: &str, bytes: u64| Buffer::storage(gpu, name, bytes, vk::BufferUsageFlags::empty());
        let many = u64::from(capacity);
        let keys = [make("sort keys 0", 8 * many)?, make("sort keys 1", 8 * many)?];
        let values = [make("sort values 0", 4 * many)?, make("sort values 1", 4 * many)?];
        let histogram = make("sort histogram", 4 * 16 * u64::from(capacity.div_ceil(BLOCK)))?;
        let (c, h) = (Binding::Storage(counters), Binding::Storage(&histogram));
        let [k, v] = [&keys, &values].map(|pair| [Binding::Storage(&pair[0]), Binding::Storage(&pair[1])]);
        let pass = |name, words: &[u8], bindings: &[Binding<'_>]| Compute::new(gpu, name, words, bindings, &[BLOCK], 4);
        let count = |i: usize| pass("sort_count", spirv!("engine/sort_count.comp"), &[c, k[i], h]);
        let scatter = |i: usize| {
            let bindings = [c, k[i], v[i], h, k[1 - i], v[1 - i]];
            pass("sort_scatter", spirv!("engine/sort_scatter.comp"), &bindings)
        };
        Ok(Self {
            count: [count(0)?, count(1)?],
            scan: pass("sort_scan", spirv!("engine/sort_scan.comp"), &[c, h])?,
            scatter: [scatter(0)?, scatter(1)?],
            keys,
            values,
            histogram,
            device: gpu.device.clone(),
        })
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.keys.iter().chain(&self.values).chain([&self.histogram]).map(|b| b.size).sum()
    }

    /// Sorts by an even number of `digits` of 4 bits. `blocks`: offset in bytes of the dispatch over the blocks; `one`: of
    /// that of a single group, where there is not always something to sort. The caller has ordered the writes of keys, values,
    /// counters and arguments before.
    pub(crate) fn record(
        &self,
        cmd: vk::CommandBuffer,
        digits: u32,
        arguments: &Buffer,
        blocks: u64,
        one: Option<u64>,
    ) {
        let next = || sync::barrier(&self.device, cmd, &[(Access::ComputeWrite, Access::ComputeWrite)]);
        for digit in 0..digits {
            let side = (digit % 2) as usize;
            self.count[side].dispatch_indirect(cmd, &(4 * digit), arguments, blocks);
            next();
            match one {
                Some(one) => self.scan.dispatch_indirect(cmd, &16u32, arguments, one),
                None => self.scan.dispatch(cmd, &16u32, [1, 1, 1]),
            };
            next();
            self.scatter[side].dispatch_indirect(cmd, &(4 * digit), arguments, blocks);
            next();
        }
    }
}

pub(crate) struct Sort {
    pub(crate) capacity: u32,
    passes: Passes,
    prepare: Compute,
    device: ash::Device,
}

impl Sort {
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        counters: &Buffer,
        argument_buffer: &Buffer,
        capacity: u32,
    ) -> Result<Self, Error> {
        Ok(Self {
            passes: Passes::new(gpu, counters, capacity)?,
            prepare: Compute::new(
                gpu,
                "sort_prepare",
                spirv!("engine/sort_prepare.comp"),
                &[Binding::Storage(counters), Binding::Storage(argument_buffer)],
                &[BLOCK],
                size_of::<PreparePush>(),
            )?,
            capacity,
            device: gpu.device.clone(),
        })
    }

    /// Keys before and after sorting.
    pub(crate) fn keys(&self) -> &Buffer {
        &self.passes.keys[0]
    }

    /// Values before and after sorting.
    pub(crate) fn values(&self) -> &Buffer {
        &self.passes.values[0]
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.passes.bytes()
    }

    /// Sorts; the caller has ordered the writes of keys, values and counters before compute reads.
    pub(crate) fn record(&self, cmd: vk::CommandBuffer, b: &Buffers) {
        self.record_digits(cmd, &b.arguments, arguments::SORT, DIGITS);
    }

    /// The same by an even number of `digits` of 4 bits, with three words of a buffer of arguments from `argument` on.
    pub(crate) fn record_digits(&self, cmd: vk::CommandBuffer, buffer: &Buffer, argument: u32, digits: u32) {
        use Access::*;
        self.prepare.dispatch(cmd, &PreparePush { capacity: self.capacity, argument }, [1, 1, 1]);
        sync::barrier(&self.device, cmd, &[(ComputeWrite, ComputeWrite), (ComputeWrite, IndirectRead)]);
        self.passes.record(cmd, digits, buffer, 4 * u64::from(argument), None);
    }
}
