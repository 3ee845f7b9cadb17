//! The adaptive shadow map on the GPU (Lefohn et al. 2005; book, 4.4.1): in every frame all samples at shadow edges ask for the
//! pages they need, each page is made once, and all is repeated until no sample asks.

use super::comparison::Comparison;
use super::quadtree::{self, Quadtree, Settings};
use super::{FrameTimes, Method, MethodInfo, MethodSpec, Parameter, Statistics};
use crate::engine::sort::Sort;
use crate::gpu::structs::{AsmGpuCounts, AsmGpuPush, Counters};
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Buffer, Compute, spirv};
use crate::lab::{Lab, LabError};
use ash::vk;

const PARAMETERS: [Parameter; 12] = Comparison::keys(&[
    quadtree::MEMORY,
    quadtree::CELL,
    quadtree::START,
    quadtree::VIRTUAL,
    quadtree::LEVEL,
    quadtree::LEVEL_BIAS,
    Parameter {
        key: "iterations",
        default: "8",
        allowed: "1 to 16",
        meaning: "most times in a frame that samples ask and pages are made",
    },
]);

pub(super) const INFO: MethodInfo = MethodInfo {
    name: "asm_gpu",
    source: "Lefohn, Sengupta, Kniss, Strzodka, Owens 2005; Eisemann et al. 2011, 4.4.1",
    summary: "Samples at shadow edges ask for pages of a quadtree, again and again in every frame until none is missing",
    parameters: &PARAMETERS,
    check: |spec| keys(spec).map(|_| ()),
    create: |spec, lab| Ok(Box::new(AsmGpu::new(spec, lab)?)),
};

fn keys(spec: &MethodSpec) -> Result<(Settings, u32), LabError> {
    Ok((Settings::of(spec)?, spec.u32_in("iterations", 8, 1..=16)?))
}

/// Words of indirect dispatches: over the blocks of the sort, and over the pixels that ask.
const SORT: u32 = 0;
const ASK: u32 = 3;
/// Passes of the sort: 4 bits each of 40-bit keys.
const DIGITS: u32 = 10;

pub(super) struct AsmGpu {
    tree: Quadtree,
    iterations: u32,
    counters: Buffer,
    counts: Buffer,
    arguments: Buffer,
    sort: Sort,
    request: Compute,
    allocate: Compute,
    insert: Compute,
}

impl AsmGpu {
    fn new(spec: &MethodSpec, lab: &Lab) -> Result<Self, LabError> {
        let (settings, iterations) = keys(spec)?;
        let (tiles, cells) = (settings.tiles, settings.sparse_cells());
        let tree = Quadtree::new(spec, lab, settings, cells)?;
        let gpu = lab.gpu();
        let storage = |name, bytes: usize, extra| Buffer::storage(gpu, name, bytes as u64, extra);
        let none = vk::BufferUsageFlags::empty();
        let counters = storage("request counters", size_of::<Counters>(), none)?;
        let counts = storage("adaptive map counts", size_of::<AsmGpuCounts>(), none)?;
        let arguments = storage("request dispatches", 24, vk::BufferUsageFlags::INDIRECT_BUFFER)?;
        let [width, height] = lab.view().size;
        // room for a request of every pixel
        let sort = Sort::new(gpu, &counters, &arguments, width * height)?;
        let (asked, keys) = (Binding::Storage(&counters), Binding::Storage(sort.keys()));
        let own = Binding::Storage(&counts);
        let [place, cells, pages] = tree.tree();
        let drawn = tree.drawn()?;
        let request = [&tree.sampled()[..], &[asked, keys]].concat();
        Ok(Self {
            request: Compute::new(
                gpu,
                "asm_gpu_request",
                spirv!("methods/asm_gpu_request.comp"),
                &request,
                &tree.constants(&[1, 0]),
                0,
            )?,
            allocate: Compute::new(
                gpu,
                "asm_gpu_allocate",
                spirv!("methods/asm_gpu_allocate.comp"),
                &[asked, keys, pages, drawn, own, Binding::Storage(&arguments)],
                &tree.constants(&[tiles]),
                size_of::<AsmGpuPush>(),
            )?,
            insert: Compute::new(
                gpu,
                "asm_gpu_insert",
                spirv!("methods/asm_gpu_insert.comp"),
                &[place, cells, pages, tree.fits(), drawn, own],
                &tree.constants(&[tiles]),
                0,
            )?,
            tree,
            iterations,
            counters,
            counts,
            arguments,
            sort,
        })
    }

    /// Samples ask, pages are made and drawn; the last time only to see whether any is missing.
    fn iterate(&self, lab: &Lab, cmd: vk::CommandBuffer, iteration: u32) {
        use Access::*;
        let device = &lab.gpu().device;
        let next = || sync::barrier(device, cmd, &[(ComputeWrite, ComputeWrite), (ComputeWrite, ComputeRead)]);
        let groups = lab.view().size.map(|side| side.div_ceil(8));
        let last = iteration == self.iterations;
        if iteration == 0 {
            self.request.dispatch(cmd, &(), [groups[0], groups[1], 1]);
        } else {
            self.request.dispatch_indirect(cmd, &(), &self.arguments, 4 * u64::from(ASK));
        }
        sync::barrier(device, cmd, &[(ComputeWrite, ComputeWrite), (IndirectRead, ComputeWrite)]);
        self.sort.record_digits(cmd, &self.arguments, SORT, DIGITS);
        let push = AsmGpuPush { first: u32::from(iteration == 0), last: last.into(), groups, argument: ASK };
        self.allocate.dispatch(cmd, &push, [1, 1, 1]);
        sync::barrier(device, cmd, &[(ComputeWrite, ComputeWrite), (ComputeWrite, IndirectRead)]);
        if !last {
            self.insert.dispatch(cmd, &(), [self.tree.tile_count().div_ceil(64), 1, 1]);
            next();
            self.tree.record_draw(lab, cmd);
        }
    }
}

impl Method for AsmGpu {
    fn frame(&mut self, lab: &Lab) -> Result<FrameTimes, LabError> {
        let seen = self.tree.look(lab, false)?;
        let camera = lab.camera_constants()?;
        let device = &lab.gpu().device;
        lab.frame(|cmd, timer| {
            self.tree.record_begin(lab, &camera, (cmd, timer), &seen, |cmd| {
                // SAFETY: the command buffer is recording; the map's commands wait for the last frame and for this
                unsafe { device.cmd_fill_buffer(cmd, self.counters.raw, 0, vk::WHOLE_SIZE, 0) };
            });
            self.tree.record_draw(lab, cmd);
            timer.mark(cmd, "start");
            for iteration in 0..=self.iterations {
                self.iterate(lab, cmd, iteration);
            }
            timer.mark(cmd, "iterations");
            self.tree.record_lookup(lab, cmd, timer);
        })
    }

    of_maps!(self, INFO.name, &self.tree.screen, &self.tree.map);

    fn memory(&self) -> Vec<(&'static str, u64)> {
        let mut all = self.tree.memory();
        all.push(("requests", self.counters.size + self.counts.size + self.arguments.size + self.sort.bytes()));
        all
    }

    fn statistics(&mut self, lab: &Lab) -> Result<Statistics, LabError> {
        let mut statistics = self.tree.statistics(lab)?;
        let counts: AsmGpuCounts =
            bytemuck::pod_read_unaligned(&lab.read_buffer(&self.counts)?[..size_of::<AsmGpuCounts>()]);
        statistics.counters.extend([
            ("page_capacity", u64::from(self.tree.tile_count())),
            ("pages_resident", u64::from(counts.resident)),
            ("pages_requested", u64::from(counts.requested)),
            ("requests_outstanding", u64::from(counts.outstanding)),
            ("iterations", u64::from(counts.iterations)),
        ]);
        Ok(statistics)
    }
}
