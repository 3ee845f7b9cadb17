//! The passes that warp the layers of a parallel light's map (book, 4.2): `glsl/methods/warp_*.comp`. They come after the fit to
//! the samples, which stays where a warp does not serve.

use super::map::{Map, Screen};
use super::map_light;
use crate::gpu::structs::{WarpMeasure, WarpPush, WarpRecord};
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Buffer, Compute, Gpu, spirv};
use crate::lab::{Lab, LabError};
use ash::vk;
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
        }
    }
}

/// The view direction as the view's first light sees it, and the sine of the angle between the two.
pub(super) fn axis(lab: &Lab) -> Result<(DVec2, f64), LabError> {
    let [x, y, _] = crate::engine::constants::light_axes(map_light::direction(&lab.view().lights[0]))?;
    let forward = -lab.view().camera.view_from_world().row(2);
    let seen = DVec2::new(forward.dot(x), forward.dot(y));
    Ok((seen.normalize_or(DVec2::Y), seen.length()))
}

/// A warp for each layer of a map.
pub(super) struct Passes {
    rule: Rule,
    always: bool,
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
            records,
            gpu: gpu.clone(),
        })
    }

    /// Among a frame's first transfers.
    pub(super) fn reset(&self, cmd: vk::CommandBuffer) {
        // SAFETY: the command buffer is recording; the map's own commands wait for the last frame and for this
        unsafe { self.gpu.device.cmd_fill_buffer(cmd, self.records.raw, 0, vk::WHOLE_SIZE, 0) };
    }

    /// After the layers were fitted: the warps that serve, in place of those fits. `axis`: as [`axis`].
    pub(super) fn record(&self, cmd: vk::CommandBuffer, (screen, map): (&Screen, &Map), (axis, sine): (DVec2, f64)) {
        use Access::*;
        let next = || sync::barrier(&self.gpu.device, cmd, &[(ComputeWrite, ComputeWrite)]);
        let axis = axis.as_vec2().to_array();
        let resolution = map.shape().side as f32;
        for step in 0..3 {
            self.measure.dispatch(cmd, &WarpMeasure { axis, step, resolution }, screen.columns());
            next();
            let push = WarpPush {
                axis,
                step,
                resolution,
                border: map.shape().border() as f32,
                sine: sine as f32,
                parameter: self.rule.words().1,
                always: u32::from(self.always),
            };
            self.choose.dispatch(cmd, &push, [map.shape().layers, 1, 1]);
            next();
        }
    }

    /// Layers that the last frame warped.
    pub(super) fn warped(&self, lab: &Lab) -> Result<u64, LabError> {
        let records: Vec<WarpRecord> = bytemuck::pod_collect_to_vec(&lab.read_buffer(&self.records)?);
        Ok(records.iter().map(|record| u64::from(record.warped)).sum())
    }
}
