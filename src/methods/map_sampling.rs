//! The sampling errors of a fitted map: `glsl/methods/map_sampling.comp`.

use super::map::{Map, Screen};
use super::map_light::Kind;
use super::sampling::{Sampling, SamplingInputs, measure};
use crate::gpu::structs::{Frame, MapLight, Slices};
use crate::gpu::{Binding, Buffer, Compute, spirv};
use crate::lab::{Lab, LabError};

/// Those of the last frame.
pub(super) fn sampling(lab: &Lab, screen: &Screen, map: &Map) -> Result<Sampling, LabError> {
    let words = spirv!("methods/map_sampling.comp");
    sampling_by(lab, (screen, map), (words, map.fits(), map.shape().tiled), &[], &[])
}

/// Those of a map whose texels are not those of its fit: a shader, the fits that it takes, whether layers were picked, and the binding
/// and the constant that it has beside.
pub(super) fn sampling_by(
    lab: &Lab,
    (screen, map): (&Screen, &Map),
    (words, fits, picked): (&[u8], &Buffer, bool),
    binding: &[Binding<'_>],
    constant: &[u32],
) -> Result<Sampling, LabError> {
    let shape = map.shape();
    let position = map.kind() != Kind::Parallel;
    let side = shape.side as f32;
    let errors = measure(lab, &side, |target| {
        let own = [Binding::Storage(fits), target, map.picked()];
        let bindings = [&map.samples(screen)[..], &own, binding].concat();
        let constants = [&[shape.fitted(), position.into(), 0, 0, 0, 0, picked.into()], constant].concat();
        Compute::new(lab.gpu(), "map_sampling", words, &bindings, &constants, 4)
    })?;
    let slices: Slices = bytemuck::pod_read_unaligned(&lab.read_buffer(map.slices())?[..size_of::<Slices>()]);
    let inputs = SamplingInputs {
        frame: bytemuck::pod_read_unaligned(&lab.read_buffer(&screen.frame)?[..size_of::<Frame>()]),
        light: bytemuck::pod_read_unaligned(&lab.read_buffer(map.light())?[..size_of::<MapLight>()]),
        position,
        fits: bytemuck::pod_collect_to_vec(&lab.read_buffer(fits)?),
        splits: slices.splits[..shape.fitted() as usize].to_vec(),
        nearest: (slices.exits[0][3] != 0.0).then(|| f32::from_bits(!slices.extremes[1])),
        side: shape.side,
        warp: None,
    };
    Ok(Sampling {
        size: lab.view().size,
        errors,
        part_texels: f64::from(shape.side) * f64::from(shape.side),
        inputs: Some(inputs),
    })
}
