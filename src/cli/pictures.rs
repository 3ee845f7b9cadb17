//! What a visibility image looks like.

use umbrage::Light;
use umbrage::lab::Lab;
use umbrage::output::{self, OutputError, Picture};
use umbrage::truth::{GBuffer, Reference};

/// The light that is measured; a checked view has one.
fn light(lab: &Lab) -> Result<&Light, OutputError> {
    let missing = || OutputError { path: "view".to_owned(), what: "it has no light".to_owned() };
    lab.view().lights.first().ok_or_else(missing)
}

/// The scene in the light that `visibility` lets through.
pub fn shaded(lab: &Lab, gbuffer: &GBuffer, visibility: &[f32]) -> Result<Picture, OutputError> {
    output::shade(gbuffer, &lab.view().camera, lab.scene().origin, light(lab)?, visibility)
}

/// Where `visibility` differs from the reference.
pub fn difference(
    lab: &Lab,
    gbuffer: &GBuffer,
    visibility: &[f32],
    reference: &Reference,
) -> Result<Picture, OutputError> {
    output::difference(visibility, reference, gbuffer, light(lab)?, lab.scene().origin)
}
