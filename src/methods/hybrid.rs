//! A conventional map with exact edges (after Chan, Durand 2004; book, 2.4.7): where the texels around a sample agree they decide
//! it; where they do not, a ray against the casters does. The source draws shadow volumes there; any exact test serves.

use super::changes::Changes;
use super::comparison::{CULL, DEPTH_BIAS};
use super::map::{self, Screen, Step};
use super::uniform::{FIT, RESOLUTION, SIDE, Uniform};
use super::{FrameTimes, Masks, Method, MethodInfo, MethodSpec, Parameter, Sampling, Statistics, comparison, uniform};
use crate::Config;
use crate::engine::bvh::{Bvh, CHANGED_SHAPE};
use crate::engine::constants::ray_start;
use crate::engine::exact::Exact;
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Compute, Image, ImageSpec, spirv};
use crate::lab::{Lab, LabError};
use ash::vk;

const PARAMETERS: &[Parameter] = &[
    RESOLUTION,
    FIT,
    Parameter {
        key: "reach",
        default: "1",
        allowed: "1 to 4",
        meaning: "texels around a sample's own, either way, that must agree with it",
    },
    DEPTH_BIAS,
    CULL,
];

pub(super) const INFO: MethodInfo = MethodInfo {
    name: "hybrid",
    source: "Chan, Durand 2004; Eisemann et al. 2011, 2.4.7",
    summary: "One map, and rays against the casters where its texels disagree about a sample",
    parameters: PARAMETERS,
    check: |spec| settings(spec).map(|_| ()),
    create: |spec, lab| Ok(Box::new(Hybrid::new(spec, lab)?)),
};

/// The key `reach`.
fn settings(spec: &MethodSpec) -> Result<u32, LabError> {
    uniform::settings(spec, SIDE)?;
    spec.u32_in("reach", 1, 1..=4)
}

pub(super) struct Hybrid {
    base: Uniform,
    mask: Image,
    bvh: Bvh,
    exact: Exact,
    mark: Compute,
    changes: Changes,
}

impl Hybrid {
    pub(super) fn new(spec: &MethodSpec, lab: &Lab) -> Result<Self, LabError> {
        super::one_directional(spec, lab)?;
        let (gpu, scene) = (lab.gpu(), lab.scene_buffers());
        let base = Uniform::new(spec, lab, uniform::settings(spec, SIDE)?, Screen::new(lab)?)?;
        let map = &base.maps[0];
        let [width, height] = lab.view().size;
        let usage = vk::ImageUsageFlags::STORAGE | vk::ImageUsageFlags::TRANSFER_SRC;
        let format = vk::Format::R32_UINT;
        let mask = Image::new(gpu, "mask", &ImageSpec { format, width, height, layers: 1, usage })?;
        let config = Config { cull: comparison::cull(spec)?, ..Config::new([width, height]) };
        let bvh = Bvh::new(gpu, scene)?;
        let frame = Binding::Uniform(&base.screen.frame);
        let exact = Exact::new(gpu, &config, scene, Some(&bvh), width * height, frame, Some(&mask))?;
        let own = [
            Binding::Storage(map.fits()),
            Binding::Sampled(map.image()),
            Binding::StorageImage(&mask),
            Binding::Storage(&exact.count),
            Binding::Storage(&exact.items),
            Binding::Storage(&exact.rays),
        ];
        let bindings = [&map.samples(&base.screen)[..], &own].concat();
        let constants = [1, 0, settings(spec)?];
        let mark = Compute::new(gpu, "hybrid_mark", spirv!("methods/hybrid_mark.comp"), &bindings, &constants, 0)?;
        Ok(Self { base, mask, bvh, exact, mark, changes: Changes::default() })
    }
}

impl Method for Hybrid {
    fn frame(&mut self, lab: &Lab) -> Result<FrameTimes, LabError> {
        let given = self.base.given(lab)?;
        let mut camera = lab.camera_constants()?;
        camera.rule[3] = ray_start(lab.scene_buffers());
        let stale = self.changes.since(lab).is_none_or(|moved| !moved.is_empty());
        let device = &lab.gpu().device;
        let reset = |step, cmd| {
            if step == Step::Reset {
                // SAFETY: the command buffer is recording; earlier uses are waited for
                unsafe {
                    device.cmd_fill_buffer(cmd, self.exact.count.raw, 0, vk::WHOLE_SIZE, 0);
                    device.cmd_fill_buffer(cmd, self.bvh.changes.raw, 0, vk::WHOLE_SIZE, CHANGED_SHAPE);
                }
                self.bvh.record_reset(cmd);
            }
        };
        lab.frame(|cmd, timer| {
            use Access::*;
            let (screen, map) = (&self.base.screen, &self.base.maps[0]);
            sync::barrier(device, cmd, &[(IndirectRead, ComputeWrite)]);
            map::record_fits((lab, &camera), (cmd, timer), screen, &self.base.maps, &given, reset);
            if stale {
                self.bvh.record(cmd);
                sync::barrier(device, cmd, &[(ComputeWrite, ComputeRead)]);
                timer.mark(cmd, "tree");
            }
            map.draw(lab, cmd);
            timer.mark(cmd, "map");
            sync::discard(device, cmd, &self.mask, TransferRead, StorageImage);
            let [width, height] = lab.view().size;
            self.mark.dispatch(cmd, &(), [width.div_ceil(8), height.div_ceil(8), 1]);
            sync::barrier(device, cmd, &[(ComputeWrite, ComputeWrite)]);
            timer.mark(cmd, "mark");
            self.exact.record(cmd);
            sync::image(device, cmd, &self.mask, StorageImage, TransferRead);
            timer.mark(cmd, "rays");
        })
    }

    fn visibility(&mut self, lab: &Lab, light: usize) -> Result<Vec<f32>, LabError> {
        super::of_light(&self.base.maps, INFO.name, light)?;
        Ok(bytemuck::pod_collect_to_vec(&lab.read_image(&self.mask, Access::TransferRead, 4)?))
    }

    fn masks(&self) -> Option<Masks<'_>> {
        Some(Masks { images: vec![&self.mask], bits: 32 })
    }

    fn memory(&self) -> Vec<(&'static str, u64)> {
        let mut memory = self.base.memory();
        memory.extend([("mask", self.mask.bytes), ("tree", self.bvh.bytes()), ("rays", self.exact.bytes())]);
        memory
    }

    fn sampling(&mut self, lab: &Lab, light: usize) -> Result<Option<Sampling>, LabError> {
        self.base.sampling(lab, light)
    }

    fn statistics(&mut self, lab: &Lab) -> Result<Statistics, LabError> {
        let mut statistics = self.base.statistics(lab)?;
        let count = lab.read_buffer(&self.exact.count)?;
        statistics.counters.push(("rays", u64::from(bytemuck::pod_read_unaligned::<u32>(&count[..4]))));
        Ok(statistics)
    }
}
