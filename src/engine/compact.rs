//! Leaves each key once and adds up its pixels (sort route).
//! Reads: sorted keys and counts. Writes: distinct keys, their counts, the number of distinct keys per coarsening.
//! No capacity of its own: as many entries as the sort has.

use super::buffers::{Buffers, arguments};
use super::request::SHIFTS;
use super::sort::{BLOCK, Sort};
use crate::Error;
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Buffer, Compute, Gpu, spirv};
use ash::vk;
use std::sync::Arc;

pub(crate) struct Compact {
    pub(crate) keys: Buffer,
    pub(crate) counts: Buffer,
    heads: Buffer,
    count: Compute,
    scan: Compute,
    write: Compute,
    device: ash::Device,
}

impl Compact {
    pub(crate) fn new(gpu: &Arc<Gpu>, b: &Buffers, sort: &Sort) -> Result<Self, Error> {
        let make =
            |name: &str, words: u32| Buffer::storage(gpu, name, 4 * u64::from(words), vk::BufferUsageFlags::empty());
        let (keys, counts) = (make("distinct keys", 2 * sort.capacity)?, make("distinct counts", sort.capacity)?);
        let heads = make("compact heads", sort.capacity.div_ceil(BLOCK))?;
        let c = Binding::Storage(&b.counters);
        let sorted = [Binding::Storage(sort.keys()), Binding::Storage(sort.values())];
        let count = [c, sorted[0], Binding::Storage(&heads)];
        let write =
            [c, sorted[0], sorted[1], Binding::Storage(&heads), Binding::Storage(&keys), Binding::Storage(&counts)];
        Ok(Self {
            count: Compute::new(
                gpu,
                "compact_count",
                spirv!("engine/compact_count.comp"),
                &count,
                &[BLOCK, SHIFTS[1], SHIFTS[2], SHIFTS[3]],
                0,
            )?,
            scan: Compute::new(gpu, "compact_scan", spirv!("engine/sort_scan.comp"), &[c, count[2]], &[BLOCK], 4)?,
            write: Compute::new(gpu, "compact_write", spirv!("engine/compact_write.comp"), &write, &[BLOCK], 0)?,
            keys,
            counts,
            heads,
            device: gpu.device.clone(),
        })
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.keys.size + self.counts.size + self.heads.size
    }

    pub(crate) fn record(&self, cmd: vk::CommandBuffer, b: &Buffers) {
        use Access::*;
        let offset = 4 * u64::from(arguments::SORT);
        self.count.dispatch_indirect(cmd, &(), &b.arguments, offset);
        sync::barrier(&self.device, cmd, &[(ComputeWrite, ComputeWrite)]);
        self.scan.dispatch(cmd, &1u32, [1, 1, 1]);
        sync::barrier(&self.device, cmd, &[(ComputeWrite, ComputeWrite)]);
        self.write.dispatch_indirect(cmd, &(), &b.arguments, offset);
    }
}
