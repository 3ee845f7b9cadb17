//! The passes that warp the layers of a parallel light's map (book, 4.2): `glsl/methods/warp_*.comp`. They come after the fit to
//! the samples, which stays where a warp does not serve.

use super::map::{Map, Screen};
use super::map_light;
use crate::gpu::structs::{WarpMeasure, WarpPush, WarpRecord};
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Buffer, Compute, Gpu, spirv};
use crate::lab::{Lab, LabError};
use ash::vk;
use bytemuck::Zeroable;
use glam::DVec2;
use std::sync::Arc;

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
    /// As [`super::plane::Plane`] has it.
    Plane,
    /// Where the depth from the eye would be 0, if it grew evenly from the nearest sample to the farthest over their extent.
    Depth,
}

impl Rule {
    fn words(self) -> (u32, f32) {
        match self {
            Rule::Even => (0, 0.0),
            Rule::Eye => (1, 0.0),
            Rule::Focus(share) => (2, share),
            Rule::Distance(distance) => (3, distance),
            Rule::Depth => (4, 0.0),
            Rule::Plane => (5, 0.0),
        }
    }
}

/// The way across the light in which texels of a layer may grow.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis {
    direction: DVec2,
    /// Of the angle between view and light, 1 for a side of the view frustum; 0: none.
    sine: f64,
    /// Whether depths grow along it from 0 at the eye.
    through_eye: bool,
}

impl Axis {
    /// Of a layer that is not to be warped.
    pub(super) const NONE: Axis = Axis { direction: DVec2::Y, sine: 0.0, through_eye: false };

    /// Of a layer whose depths have a gradient across the light, and are 0 at the eye.
    pub(super) fn through_eye(gradient: DVec2) -> Self {
        gradient.try_normalize().map_or(Self::NONE, |direction| Self { direction, sine: 1.0, through_eye: true })
    }
}

/// The view direction as the view's first light sees it.
pub(super) fn axis(lab: &Lab) -> Result<Axis, LabError> {
    let [x, y, _] = crate::engine::constants::light_axes(map_light::direction(&lab.view().lights[0]))?;
    let forward = -lab.view().camera.view_from_world().row(2);
    let seen = DVec2::new(forward.dot(x), forward.dot(y));
    Ok(Axis { direction: seen.normalize_or(DVec2::Y), sine: seen.length(), through_eye: false })
}

/// A warp for each layer of a map.
pub(super) struct Passes {
    rule: Rule,
    always: bool,
    layers: u32,
    records: Buffer,
    measure: Compute,
    choose: Compute,
    gpu: Arc<Gpu>,
}

impl Passes {
    /// `always`: whether warps serve even where they gain nothing; `logarithm`: whether they are logarithmic along the axis.
    pub(super) fn new(
        lab: &Lab,
        screen: &Screen,
        map: &Map,
        (rule, always, logarithm): (Rule, bool, bool),
    ) -> Result<Self, LabError> {
        let gpu = lab.gpu();
        let layers = map.shape().layers;
        let bytes = size_of::<WarpRecord>() as u64 * u64::from(layers);
        let records = Buffer::storage(gpu, "warps", bytes, vk::BufferUsageFlags::empty())?;
        let own = [Binding::Storage(&records), Binding::Storage(map.fits())];
        let measured = [&map.samples(screen)[..], &own].concat();
        let (measure, choose) = (spirv!("methods/warp_measure.comp"), spirv!("methods/warp_choose.comp"));
        let constants = [layers, 0, 0, 0, 0, map.shape().blend.to_bits()];
        Ok(Self {
            measure: Compute::new(gpu, "warp_measure", measure, &measured, &constants, size_of::<WarpMeasure>())?,
            choose: Compute::new(
                gpu,
                "warp_choose",
                choose,
                &own,
                &[rule.words().0, logarithm.into()],
                size_of::<WarpPush>(),
            )?,
            rule,
            always,
            layers,
            records,
            gpu: gpu.clone(),
        })
    }

    /// Among a frame's first transfers. `axes`: of each layer.
    pub(super) fn reset(&self, cmd: vk::CommandBuffer, axes: &[Axis]) {
        let record = |axis: &Axis| WarpRecord {
            through_eye: axis.through_eye.into(),
            axis: axis.direction.as_vec2().to_array(),
            sine: axis.sine as f32,
            ..WarpRecord::zeroed()
        };
        let records: Vec<_> = axes[..self.layers as usize].iter().map(record).collect();
        // SAFETY: the command buffer is recording, the data is smaller than 64 KiB; the map's own commands wait for the last
        // frame and for this
        unsafe { self.gpu.device.cmd_update_buffer(cmd, self.records.raw, 0, bytemuck::cast_slice(&records)) };
    }

    /// After the layers were fitted: the warps that serve, in place of those fits.
    pub(super) fn record(&self, cmd: vk::CommandBuffer, screen: &Screen, map: &Map) {
        use Access::*;
        let next = || sync::barrier(&self.gpu.device, cmd, &[(ComputeWrite, ComputeWrite)]);
        let resolution = map.shape().side as f32;
        for step in 0..3 {
            self.measure.dispatch(cmd, &WarpMeasure { step, resolution }, screen.columns());
            next();
            let push = WarpPush {
                step,
                resolution,
                border: map.shape().border() as f32,
                parameter: self.rule.words().1,
                always: u32::from(self.always),
            };
            self.choose.dispatch(cmd, &push, [map.shape().layers, 1, 1]);
            next();
        }
    }

    /// The warps of the last frame, one for each layer.
    pub(super) fn records(&self) -> &Buffer {
        &self.records
    }

    /// Layers that the last frame warped.
    pub(super) fn warped(&self, lab: &Lab) -> Result<u64, LabError> {
        self.count(lab, |record| record.warped)
    }

    /// Layers in which the last frame moved the line of the rule, as it met the samples.
    pub(super) fn moved(&self, lab: &Lab) -> Result<u64, LabError> {
        self.count(lab, |record| record.moved)
    }

    fn count(&self, lab: &Lab, which: impl Fn(&WarpRecord) -> u32) -> Result<u64, LabError> {
        let records: Vec<WarpRecord> = bytemuck::pod_collect_to_vec(&lab.read_buffer(&self.records)?);
        Ok(records.iter().map(|record| u64::from(which(record))).sum())
    }
}
