//! What the methods with a perspective warp share (book, 4.2): one map of a parallel light, fitted on the GPU to the visible
//! samples, then warped so that texels are smaller where the eye is near. A warp whose texels would look larger in the image
//! than those of the fit without one, on the mean over the samples, does not serve.

use super::comparison::Comparison;
use super::map::{self, Given, Map, Screen, Shape, Step};
use super::{FrameTimes, Masks, Method, MethodSpec, Parameter, Sampling, Statistics, map_light, map_sampling};
use crate::gpu::structs::{Slices, WarpMeasure, WarpPush, WarpRecord};
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Buffer, Compute, spirv};
use crate::lab::{Lab, LabError};
use ash::vk;
use bytemuck::Zeroable;
use glam::DVec2;

/// Keys that come after those of each.
pub(super) const RESOLUTION: Parameter =
    Parameter { key: "resolution", default: "4096", allowed: "64 to 16384", meaning: "side of the map in texels" };
pub(super) const WARP: Parameter = Parameter {
    key: "warp",
    default: "auto",
    allowed: "auto or always",
    meaning: "whether the warp serves only where its texels look smaller, on the mean over the image, than without",
};

/// How the line is chosen from which texels shrink; as in `glsl/methods/warp_choose.comp`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Rule {
    /// The distance that spreads the error evenly.
    Even,
    /// Through the eye.
    Eye,
    /// So that this share of the samples' extent gets four fifths of the map.
    Focus(f32),
    /// This far before the nearest sample, in world units.
    Distance(f32),
}

impl Rule {
    fn words(self) -> (u32, f32) {
        match self {
            Rule::Even => (0, 0.0),
            Rule::Eye => (1, 0.0),
            Rule::Focus(share) => (2, share),
            Rule::Distance(distance) => (3, distance),
        }
    }
}

pub(super) struct Settings {
    resolution: u32,
    rule: Rule,
    always: bool,
    comparison: Comparison,
}

/// What all of them take, with a rule of their own.
pub(super) fn settings(spec: &MethodSpec, rule: Rule) -> Result<Settings, LabError> {
    Ok(Settings {
        resolution: spec.u32_in(RESOLUTION.key, 4096, 64..=16384)?,
        rule,
        always: spec.one_of(WARP.key, WARP.default, &["auto", "always"])? == "always",
        comparison: Comparison::of(spec)?,
    })
}

pub(super) struct Warp {
    name: &'static str,
    settings: Settings,
    screen: Screen,
    map: [Map; 1],
    record: Buffer,
    measure: Compute,
    choose: Compute,
}

impl Warp {
    pub(super) fn new(name: &'static str, spec: &MethodSpec, lab: &Lab, settings: Settings) -> Result<Self, LabError> {
        super::one_directional(spec, lab)?;
        let gpu = lab.gpu();
        let screen = Screen::new(lab)?;
        let Settings { resolution: side, comparison, .. } = settings;
        let map = Map::new(
            spec,
            lab,
            &screen,
            &lab.view().lights[0],
            Shape { side, layers: 1, tiled: false, blend: 0.0, comparison },
        )?;
        let record = Buffer::storage(gpu, "warp", size_of::<WarpRecord>() as u64, vk::BufferUsageFlags::empty())?;
        let own = [Binding::Storage(&record), Binding::Storage(map.fits())];
        let measured = [&map.samples(&screen)[..], &own].concat();
        let (measure, choose) = (spirv!("methods/warp_measure.comp"), spirv!("methods/warp_choose.comp"));
        Ok(Self {
            name,
            measure: Compute::new(gpu, "warp_measure", measure, &measured, &[1, 0], size_of::<WarpMeasure>())?,
            choose: Compute::new(gpu, "warp_choose", choose, &own, &[settings.rule.words().0], size_of::<WarpPush>())?,
            settings,
            screen,
            map: [map],
            record,
        })
    }

    /// The view direction as the light sees it, and the sine of the angle between the two.
    fn axis(&self, lab: &Lab) -> Result<(DVec2, f64), LabError> {
        let [x, y, _] = crate::engine::constants::light_axes(map_light::direction(&lab.view().lights[0]))?;
        let forward = -lab.view().camera.view_from_world().row(2);
        let seen = DVec2::new(forward.dot(x), forward.dot(y));
        Ok((seen.normalize_or(DVec2::Y), seen.length()))
    }

    /// After the map was fitted: the warp, if it serves, in place of that fit.
    fn warp(&self, lab: &Lab, cmd: vk::CommandBuffer, (axis, sine): (DVec2, f64)) {
        use Access::*;
        let next = || sync::barrier(&lab.gpu().device, cmd, &[(ComputeWrite, ComputeWrite)]);
        let axis = axis.as_vec2().to_array();
        let resolution = self.settings.resolution as f32;
        for step in 0..3 {
            self.measure.dispatch(cmd, &WarpMeasure { axis, step, resolution }, self.screen.columns());
            next();
            let push = WarpPush {
                axis,
                step,
                resolution,
                border: self.map[0].shape().border() as f32,
                sine: sine as f32,
                parameter: self.settings.rule.words().1,
                always: u32::from(self.settings.always),
            };
            self.choose.dispatch(cmd, &push, [1, 1, 1]);
            next();
        }
    }
}

impl Method for Warp {
    fn frame(&mut self, lab: &Lab) -> Result<FrameTimes, LabError> {
        map::check_lights(lab, &self.map)?;
        let light = map_light::constants(&lab.view().lights[0], lab, self.settings.comparison.bias_texels)?;
        let given = Given { light, fits: None, slices: Slices::zeroed() };
        let axis = self.axis(lab)?;
        let camera = lab.camera_constants()?;
        let steps = |step, cmd| match step {
            // SAFETY: the command buffer is recording; the map's own commands wait for the last frame and for this
            Step::Reset => unsafe {
                lab.gpu().device.cmd_fill_buffer(cmd, self.record.raw, 0, vk::WHOLE_SIZE, 0);
            },
            Step::Slice => {}
            Step::Fitted => self.warp(lab, cmd, axis),
        };
        lab.frame(|cmd, timer| map::record((lab, &camera), (cmd, timer), &self.screen, &self.map, &[given], steps))
    }

    fn visibility(&mut self, lab: &Lab, light: usize) -> Result<Vec<f32>, LabError> {
        super::of_light(&self.map, self.name, light)?.visibility(lab)
    }

    fn sampling(&mut self, lab: &Lab, light: usize) -> Result<Option<Sampling>, LabError> {
        super::of_light(&self.map, self.name, light)
            .and_then(|map| map_sampling::sampling(lab, &self.screen, map))
            .map(Some)
    }

    fn masks(&self) -> Option<Masks<'_>> {
        Some(map::masks(&self.map))
    }

    fn memory(&self) -> Vec<(&'static str, u64)> {
        map::memory(&self.screen, &self.map)
    }

    fn statistics(&mut self, lab: &Lab) -> Result<Statistics, LabError> {
        let mut statistics = map::statistics(lab, &self.map)?;
        let record: WarpRecord =
            bytemuck::pod_read_unaligned(&lab.read_buffer(&self.record)?[..size_of::<WarpRecord>()]);
        statistics.counters.push(("warped", u64::from(record.warped)));
        Ok(statistics)
    }
}
