//! Loads scene and view and opens the device.

use super::args::Common;
use super::failure::Failure;
use super::print;
use super::progress::Progress;
use std::path::Path;
use std::rc::Rc;
use umbrage::lab::{Lab, LabOptions, View};
use umbrage::scene::{self, LoadOptions};
use umbrage::truth::Reference;
use umbrage::view::{DEFAULT_SIZE, ViewFile};

/// What to type for the built-in scene.
const BUILTIN: &str = "builtin";

/// Opens the bench that the arguments describe.
pub fn open(common: &Common, progress: &Progress) -> Result<Lab, Failure> {
    let file = common.view.as_deref().map(ViewFile::read).transpose()?;
    let scene = if common.scene == Path::new(BUILTIN) {
        scene::builtin()
    } else {
        let time_s = file.as_ref().map_or(0.0, ViewFile::time_s);
        let options = LoadOptions { time_s, blend_casts: common.blend_casts };
        progress.during("loading the scene", || scene::load(&common.scene, &options))?
    };
    if !common.quiet {
        scene.warnings.iter().for_each(|warning| print::warn(warning));
    }
    let view = match file {
        Some(file) => file.complete(&scene, common.size)?,
        None => progress.during("choosing a view", || View::default_for(&scene, common.size.unwrap_or(DEFAULT_SIZE))),
    };
    let options = LabOptions { device: common.device, validation: common.validation };
    Ok(progress.during("opening the device", || Lab::new(&options, scene, view))?)
}

/// Traces the rays that the results are compared with.
pub fn reference(lab: &Lab, progress: &Progress) -> Result<Rc<Reference>, Failure> {
    let bar = progress.bar("tracing the reference");
    Ok(lab.reference(&|share| bar.at(share))?)
}

/// Fails on the first message of the validation layer, where it is on.
pub fn validated(lab: &Lab) -> Result<(), Failure> {
    let messages = lab.validation_messages();
    let failure = |first| Failure::other(format!("--validation found {} messages, the first: {first}", messages.len()));
    messages.first().map_or(Ok(()), |first| Err(failure(first)))
}
