//! What the visibility of all lights looks like.

use std::rc::Rc;
use umbrage::lab::Lab;
use umbrage::output::{self, OutputError, Picture};
use umbrage::truth::{GBuffer, Reference};

/// The scene in the light that `visibility`, one image a light, lets through.
pub fn shaded(lab: &Lab, gbuffer: &GBuffer, visibility: &[Vec<f32>]) -> Result<Picture, OutputError> {
    let lights: Vec<_> = lab.view().lights.iter().zip(visibility).map(|(light, v)| (light, v.as_slice())).collect();
    output::shade(gbuffer, &lab.view().camera, lab.scene().origin, &lights)
}

/// The scene in the light that the rays of the references, one a light, found.
pub fn traced(lab: &Lab, gbuffer: &GBuffer, references: &[Rc<Reference>]) -> Result<Picture, OutputError> {
    let lit = |reference: &Rc<Reference>| reference.visibility.iter().map(|&v| f32::from(v)).collect();
    shaded(lab, gbuffer, &references.iter().map(lit).collect::<Vec<_>>())
}

/// Where `visibility` differs from the references, one image a light each.
pub fn difference(
    lab: &Lab,
    gbuffer: &GBuffer,
    visibility: &[Vec<f32>],
    references: &[Rc<Reference>],
) -> Result<Picture, OutputError> {
    let lights = lab.view().lights.iter().zip(visibility).zip(references);
    let lights: Vec<_> = lights.map(|((light, v), reference)| (light, v.as_slice(), &**reference)).collect();
    output::difference(gbuffer, lab.scene().origin, &lights)
}
