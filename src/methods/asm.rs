//! Adaptive shadow maps (Fernando et al. 2001; Fernando 2002, ch. 2; book, 4.4.1): a quadtree of shadow map pieces that is refined
//! from frame to frame where shadow edges lie whose texels are larger than pixels, the most profitable pieces first, within a
//! limit of memory.

use super::comparison::Comparison;
use super::quadtree::{self, Quadtree, Settings};
use super::{FrameTimes, Method, MethodInfo, MethodSpec, Parameter, Statistics};
use crate::gpu::structs::{AnalyzePush, AsmCounts, AsmPush, StalePush};
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Buffer, Compute, spirv};
use crate::lab::{Lab, LabError};
use ash::vk;

const PARAMETERS: [Parameter; 15] = Comparison::keys(&[
    quadtree::MEMORY,
    quadtree::CELL,
    quadtree::START,
    quadtree::VIRTUAL,
    quadtree::LEVEL,
    quadtree::LEVEL_BIAS,
    Parameter {
        key: "sampling",
        default: "8",
        allowed: "1, 2, 4, 8 or 16",
        meaning: "one in so many pixels is analysed in a frame, others in the next",
    },
    Parameter { key: "cells", default: "16", allowed: "1 to 256", meaning: "most pages made in a frame" },
    Parameter {
        key: "threshold",
        default: "1",
        allowed: "1 to 1000",
        meaning: "analysed pixels at shadow edges with too large texels for which a page is made",
    },
    Parameter {
        key: "overhead",
        default: "1",
        allowed: "0 to 1000",
        meaning: "cost of a page beside its texels, in pages' worth of texels: b / (a N) of the thesis's a N + b",
    },
]);

pub(super) const INFO: MethodInfo = MethodInfo {
    name: "asm",
    source: "Fernando, Fernandez, Bala, Greenberg 2001; Fernando 2002, ch. 2; Eisemann et al. 2011, 4.4.1",
    summary: "A quadtree of map pieces, refined from frame to frame at shadow edges by gain per cost, within a limit of memory",
    parameters: &PARAMETERS,
    check: |spec| Keys::of(spec).map(|_| ()),
    create: |spec, lab| Ok(Box::new(Asm::new(spec, lab)?)),
};

struct Keys {
    tree: Settings,
    sampling: u32,
    push: AsmPush,
}

impl Keys {
    fn of(spec: &MethodSpec) -> Result<Self, LabError> {
        let most = spec.u32_in("cells", 16, 1..=256)?;
        let threshold = spec.u32_in("threshold", 1, 1..=1000)?;
        let overhead = spec.f32_in("overhead", 1.0, 0.0..=1000.0)?;
        Ok(Self {
            tree: Settings::of(spec)?,
            sampling: spec.one_of("sampling", "8", &["1", "2", "4", "8", "16"])?.parse().unwrap_or(8),
            push: AsmPush { most, threshold, overhead },
        })
    }
}

/// Bytes of `Known` in `glsl/methods/asm_stale.comp`.
const KNOWN_BYTES: u64 = 112;

pub(super) struct Asm {
    tree: Quadtree,
    sampling: u32,
    push: AsmPush,
    known: Buffer,
    counts: Buffer,
    stale: Compute,
    analyze: Compute,
    choose: Compute,
}

impl Asm {
    fn new(spec: &MethodSpec, lab: &Lab) -> Result<Self, LabError> {
        let Keys { tree, sampling, push } = Keys::of(spec)?;
        let tiles = tree.tiles;
        let tree = Quadtree::new(spec, lab, tree, tiles)?;
        let (gpu, scene) = (lab.gpu(), lab.scene_buffers());
        let none = vk::BufferUsageFlags::empty();
        let known = Buffer::storage(gpu, "known casters", KNOWN_BYTES * u64::from(scene.instance_count), none)?;
        let counts = Buffer::storage(gpu, "adaptive map counts", size_of::<AsmCounts>() as u64, none)?;
        let stale = [
            tree.light(),
            tree.fits(),
            Binding::External(scene.instances),
            Binding::External(scene.meshes),
            Binding::Storage(&known),
            tree.drawn()?,
            Binding::Storage(&counts),
        ];
        let choose = [&tree.tree()[..], &[tree.fits(), tree.drawn()?, Binding::Storage(&counts)]].concat();
        let side = tree.settings.side as f32;
        Ok(Self {
            stale: Compute::new(
                gpu,
                "asm_stale",
                spirv!("methods/asm_stale.comp"),
                &stale,
                &[side.to_bits()],
                size_of::<StalePush>(),
            )?,
            analyze: Compute::new(
                gpu,
                "asm_analyze",
                spirv!("methods/asm_analyze.comp"),
                &tree.sampled(),
                &tree.constants(&[1, 0]),
                size_of::<AnalyzePush>(),
            )?,
            choose: Compute::new(
                gpu,
                "asm_choose",
                spirv!("methods/asm_choose.comp"),
                &choose,
                &tree.constants(&[tiles]),
                size_of::<AsmPush>(),
            )?,
            tree,
            sampling,
            push,
            known,
            counts,
        })
    }

    /// Which pixels are analysed in a frame: one of each block, another in the next frame.
    fn samples(&self, frame: u32) -> AnalyzePush {
        let bits = self.sampling.ilog2();
        let step = [1 << bits.div_ceil(2), 1 << (bits / 2)];
        // bit reversal keeps those of successive frames apart
        let turn = (frame % self.sampling).reverse_bits().checked_shr(32 - bits).unwrap_or(0);
        AnalyzePush { step, offset: [turn % step[0], turn / step[0]] }
    }
}

impl Method for Asm {
    fn frame(&mut self, lab: &Lab) -> Result<FrameTimes, LabError> {
        use Access::{ComputeRead, ComputeWrite};
        let seen = self.tree.look(lab, true)?;
        let camera = lab.camera_constants()?;
        let device = &lab.gpu().device;
        let next = |cmd| sync::barrier(device, cmd, &[(ComputeWrite, ComputeWrite), (ComputeWrite, ComputeRead)]);
        let reset = seen.place.reset;
        let instance_count = lab.scene_buffers().instance_count;
        let stale = StalePush { instance_count, tiles: self.tree.tile_count(), reset };
        let samples = self.samples(seen.place.frame);
        let [width, height] = lab.view().size;
        let groups = [width.div_ceil(8 * samples.step[0]), height.div_ceil(8 * samples.step[1]), 1];
        lab.frame(|cmd, timer| {
            self.tree.record_begin(lab, &camera, (cmd, timer), &seen, |cmd| {
                let offset = std::mem::offset_of!(AsmCounts, stale) as u64;
                // SAFETY: the command buffer is recording; the map's commands wait for the last frame and for this
                unsafe { device.cmd_fill_buffer(cmd, self.counts.raw, offset, 4, 0) };
            });
            self.stale.dispatch(cmd, &stale, [instance_count.div_ceil(64), 1, 1]);
            next(cmd);
            timer.mark(cmd, "stale");
            if reset == 1 {
                // there is nothing yet to be analysed
                self.tree.record_draw(lab, cmd);
            }
            self.analyze.dispatch(cmd, &samples, groups);
            next(cmd);
            timer.mark(cmd, "analyze");
            self.choose.dispatch(cmd, &self.push, [1, 1, 1]);
            timer.mark(cmd, "choose");
            self.tree.record_draw(lab, cmd);
            timer.mark(cmd, "map");
            self.tree.record_lookup(lab, cmd, timer);
        })
    }

    of_maps!(self, INFO.name, &self.tree.screen, &self.tree.map);

    fn memory(&self) -> Vec<(&'static str, u64)> {
        let mut all = self.tree.memory();
        all.push(("casters", self.known.size + self.counts.size));
        all
    }

    fn statistics(&mut self, lab: &Lab) -> Result<Statistics, LabError> {
        let mut statistics = self.tree.statistics(lab)?;
        let counts: AsmCounts = bytemuck::pod_read_unaligned(&lab.read_buffer(&self.counts)?[..size_of::<AsmCounts>()]);
        // pages that are put off, or may want pages of their own once they were looked at
        let deferred = counts.waiting + counts.made;
        statistics.counters.extend([
            ("page_capacity", u64::from(self.tree.tile_count())),
            ("pages_resident", u64::from(counts.resident)),
            ("pages_made", u64::from(counts.made)),
            ("pages_evicted", u64::from(counts.evicted)),
            ("pages_displaced", u64::from(counts.displaced)),
            ("pages_stale", u64::from(counts.stale)),
            ("pages_deferred", u64::from(deferred)),
        ]);
        Ok(statistics)
    }
}
