//! How large the texels of a method's map look in the image (book, 3.2): for each pixel along both axes of the map, split into
//! what perspective and what the surface's tilt does, and as the storage factor of the whole.

use super::DebugPicture;
use crate::Error;
use crate::gpu::structs::{Fit, Frame, MapLight, SamplingError};
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Buffer, Compute};
use crate::lab::{Lab, LabError};
use crate::output::{OutputError, Picture, factors, ids};
use ash::vk;
use bytemuck::Pod;
use std::collections::BTreeMap;

/// The sampling errors of one light's map over the image.
///
/// A value is the length of a texel's side in pixels, that is of a column of the Jacobian of the image against the map (book,
/// 3.2.1): above 1 the map is too coarse there.
#[derive(Debug, Clone)]
pub struct Sampling {
    /// Width and height of the image in pixels.
    pub size: [u32; 2],
    /// One a pixel, row 0 at the top.
    pub errors: Vec<SamplingError>,
    /// Texels of each part of the map: of a layer, of a page.
    pub part_texels: f64,
    /// What a fitted map's values were computed from.
    #[doc(hidden)]
    pub inputs: Option<SamplingInputs>,
}

/// What a fitted map's sampling errors follow from.
#[doc(hidden)]
#[derive(Debug, Clone)]
pub struct SamplingInputs {
    pub frame: Frame,
    pub light: MapLight,
    /// Whether the light has a position.
    pub position: bool,
    pub fits: Vec<Fit>,
    /// Distances along the view direction where layers of a parallel light begin.
    pub splits: Vec<f32>,
    /// Distance of the nearest sample along the view direction, where layers are faces of the view frustum.
    pub nearest: Option<f32>,
    /// Texels along a side of a layer.
    pub side: u32,
    /// Along each axis where the map has the ends of cells of equal width, if it is warped so.
    pub warp: Option<[Vec<f32>; 2]>,
}

impl Sampling {
    /// The pixels that look the map up.
    pub fn samples(&self) -> impl Iterator<Item = &SamplingError> {
        self.errors.iter().filter(|e| e.part != SamplingError::NO_PART)
    }

    /// Share of the samples with a texel's side longer than a pixel, in percent; 0 without samples.
    pub fn undersampled(&self) -> f64 {
        let over = self.samples().filter(|e| e.s.max(e.t) > 1.0).count();
        100.0 * over as f64 / self.samples().count().max(1) as f64
    }

    /// How many texels a pixel of the image the map would need so that no perspective error of a sample exceeds 1 (book, 3.15),
    /// with each part's two sides chosen for themselves; the sum over the parts that serve.
    pub fn storage_factor(&self) -> f64 {
        let mut greatest: BTreeMap<u32, [f32; 2]> = BTreeMap::new();
        for e in self.samples() {
            let [s, t] = greatest.entry(e.part).or_default();
            (*s, *t) = (s.max(e.perspective_s), t.max(e.perspective_t));
        }
        let pixels = f64::from(self.size[0]) * f64::from(self.size[1]);
        greatest.values().map(|[s, t]| f64::from(*s) * f64::from(*t) * self.part_texels / pixels).sum()
    }

    /// For both axes the error, its perspective part, and what remains: projection; then the parts of the map.
    ///
    /// # Errors
    /// Where there is not one value a pixel.
    pub fn pictures(&self) -> Result<Vec<DebugPicture>, OutputError> {
        type Value = fn(&SamplingError) -> f32;
        let all: [(&'static str, Value); 6] = [
            ("sampling_s", |e| e.s),
            ("sampling_s_perspective", |e| e.perspective_s),
            ("sampling_s_projection", |e| e.s / e.perspective_s),
            ("sampling_t", |e| e.t),
            ("sampling_t_perspective", |e| e.perspective_t),
            ("sampling_t_projection", |e| e.t / e.perspective_t),
        ];
        let picture = |(name, value): (&'static str, Value)| {
            let values: Vec<f32> = self
                .errors
                .iter()
                .map(|e| if e.part == SamplingError::NO_PART { f32::NAN } else { value(e) })
                .collect();
            let Picture { width, height, rgb } = factors(self.size[0], self.size[1], &values)?;
            Ok(DebugPicture { name, width, height, rgb })
        };
        let parts: Vec<u32> = self.errors.iter().map(|e| e.part).collect();
        let Picture { width, height, rgb } = ids(self.size[0], self.size[1], &parts)?;
        let parts = DebugPicture { name: "sampling_part", width, height, rgb };
        all.into_iter().map(picture).chain([Ok(parts)]).collect()
    }
}

/// Runs a pass that writes a [`SamplingError`] for each pixel of the last frame, and reads them.
pub(super) fn measure<P: Pod>(
    lab: &Lab,
    push: &P,
    pass: impl FnOnce(Binding<'_>) -> Result<Compute, Error>,
) -> Result<Vec<SamplingError>, LabError> {
    let [width, height] = lab.view().size;
    let bytes = size_of::<SamplingError>() as u64 * u64::from(width) * u64::from(height);
    let target = Buffer::storage(lab.gpu(), "sampling errors", bytes, vk::BufferUsageFlags::empty())?;
    let pass = pass(Binding::Storage(&target))?;
    lab.submit(|cmd| {
        sync::barrier(&lab.gpu().device, cmd, &[(Access::ComputeWrite, Access::ComputeRead)]);
        pass.dispatch(cmd, push, [width.div_ceil(8), height.div_ceil(8), 1]);
    })?;
    // what is allocated may be longer
    Ok(bytemuck::pod_collect_to_vec(&lab.read_buffer(&target)?[..bytes as usize]))
}
