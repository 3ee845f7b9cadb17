//! The sampling errors of a fitted map: `glsl/methods/map_sampling.comp`.

use super::map::{Map, Screen};
use super::map_light::Kind;
use super::sampling::{Sampling, SamplingInputs, measure};
use crate::gpu::structs::{Frame, MapLight, Slices};
use crate::gpu::{Binding, Compute, spirv};
use crate::lab::{Lab, LabError};

/// Those of the last frame.
pub(super) fn sampling(lab: &Lab, screen: &Screen, map: &Map) -> Result<Sampling, LabError> {
    let shape = map.shape();
    let position = map.kind() != Kind::Parallel;
    let side = shape.side as f32;
    let errors = measure(lab, &side, |target| {
        let bindings = [&map.samples(screen)[..], &[Binding::Storage(map.fits()), target, map.picked()]].concat();
        let constants = [shape.fitted(), u32::from(position), 0, 0, 0, 0, shape.tiled.into()];
        Compute::new(lab.gpu(), "map_sampling", spirv!("methods/map_sampling.comp"), &bindings, &constants, 4)
    })?;
    let slices: Slices = bytemuck::pod_read_unaligned(&lab.read_buffer(map.slices())?[..size_of::<Slices>()]);
    let inputs = SamplingInputs {
        frame: bytemuck::pod_read_unaligned(&lab.read_buffer(&screen.frame)?[..size_of::<Frame>()]),
        light: bytemuck::pod_read_unaligned(&lab.read_buffer(map.light())?[..size_of::<MapLight>()]),
        position,
        fits: bytemuck::pod_collect_to_vec(&lab.read_buffer(map.fits())?),
        splits: slices.splits[..shape.fitted() as usize].to_vec(),
        nearest: (slices.exits[0][3] != 0.0).then(|| f32::from_bits(!slices.extremes[1])),
        side: shape.side,
    };
    Ok(Sampling {
        size: lab.view().size,
        errors,
        part_texels: f64::from(shape.side) * f64::from(shape.side),
        inputs: Some(inputs),
    })
}
