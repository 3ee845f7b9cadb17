//! Loads scene and view and opens the device.

use super::args::Common;
use super::failure::Failure;
use super::print;
use super::progress::Progress;
use std::path::Path;
use std::rc::Rc;
use umbrage::lab::{Lab, LabError, LabOptions, View};
use umbrage::scene::{self, LoadOptions, Motion};
use umbrage::truth::{Reference, reference_coverage};
use umbrage::view::{DEFAULT_SIZE, ViewFile};
use umbrage::window::Content;

/// What to type for the built-in scene.
const BUILTIN: &str = "builtin";

/// Seed of the places of `--lights`.
const LIGHT_SEED: u64 = 1;

/// What moves in a scene.
#[derive(Debug, Clone, Copy)]
pub struct Movement {
    /// Whether a file's animation plays.
    pub animate: bool,
    /// Movers to add in its place; `None` adds one where something is to move and the file has no animation.
    pub movers: Option<u32>,
    /// Seed of their places.
    pub seed: u64,
    /// Copies of the scene side by side.
    pub copies: u32,
}

/// Opens the bench that the arguments describe.
pub fn open(common: &Common, progress: &Progress) -> Result<Lab, Failure> {
    open_moving(common, Movement { animate: false, movers: None, seed: 0, copies: 1 }, progress)
}

/// Opens the bench that the arguments describe, with what moves in it.
pub fn open_moving(common: &Common, movement: Movement, progress: &Progress) -> Result<Lab, Failure> {
    let Content { scene, view, motion } = load(common, movement, progress)?;
    let mut lab = progress.during("opening the device", || Lab::new(&options(common), scene, view))?;
    if let Some(motion) = motion {
        lab.set_motion(motion);
    }
    Ok(lab)
}

/// What the arguments choose about the device.
pub fn options(common: &Common) -> LabOptions {
    LabOptions { device: common.device, validation: common.validation }
}

/// Loads scene and view that the arguments describe.
pub fn load(common: &Common, movement: Movement, progress: &Progress) -> Result<Content, Failure> {
    let file = common.view.as_deref().map(ViewFile::read).transpose()?;
    let Movement { animate, movers, seed, copies } = movement;
    let (mut scene, mut motion) = if common.scene == Path::new(BUILTIN) {
        (scene::builtin(), None)
    } else {
        let time_s = file.as_ref().map_or(0.0, ViewFile::time_s);
        let options = LoadOptions { time_s, blend: common.blend.into() };
        progress.during("loading the scene", || match movers.unwrap_or(0) {
            0 if animate => scene::load_moving(&common.scene, &options),
            _ => scene::load(&common.scene, &options).map(|scene| (scene, None)),
        })?
    };
    if !common.quiet {
        scene.warnings.iter().for_each(|warning| print::warn(warning));
    }
    let mut view = match file {
        Some(file) => file.complete(&scene, common.size)?,
        None => progress.during("choosing a view", || View::default_for(&scene, common.size.unwrap_or(DEFAULT_SIZE))),
    };
    if let Some(count) = common.lights {
        view = view.with_lights(&scene, count, LIGHT_SEED);
    }
    if copies > 1 {
        if motion.is_some() {
            let scene = common.scene.display();
            return Err(Failure::from(LabError::Usage(format!(
                "--copies {copies} cannot be combined with the animation of {scene}"
            ))));
        }
        // the view is that of one copy; the others are seen behind it
        scene = scene::repeated(scene, copies);
        view.camera.far = view.camera.far.max(1.5 * scene.diagonal());
    }
    let missing = u32::from(animate && motion.is_none());
    let count = movers.unwrap_or(missing);
    if count > 0 {
        motion = Some(Motion::synthetic(&mut scene, view.camera.eye, view.camera.target, count, seed));
    }
    Ok(Content { scene, view, motion })
}

/// Traces the rays that the results are compared with, for each light of the view.
pub fn references(lab: &Lab, progress: &Progress) -> Result<Vec<Rc<Reference>>, Failure> {
    let bar = progress.bar("tracing the reference");
    let count = lab.view().lights.len();
    let one = |light| lab.reference(light, &|share| bar.at((light as f64 + share) / count as f64));
    Ok((0..count).map(one).collect::<Result<_, _>>()?)
}

/// Traces the shares of samples that each light of the view reaches, an image each.
pub fn coverages(lab: &Lab, samples: u32, progress: &Progress) -> Result<Vec<Vec<f32>>, Failure> {
    let bar = progress.bar("tracing the coverage");
    let gbuffer = lab.gbuffer()?;
    let count = lab.view().lights.len() as f64;
    let lights = (0u32..).zip(&lab.view().lights);
    let one = |(i, light): (u32, _)| {
        let share = |share| bar.at((f64::from(i) + share) / count);
        reference_coverage(lab.tracer(), lab.scene(), &gbuffer, light, samples, &share)
    };
    Ok(lights.map(one).collect::<Result<_, _>>()?)
}

/// The device in the words of a plot's title.
pub fn place(lab: &Lab) -> String {
    let name = lab.device_name();
    if lab.device_is_cpu() { format!("{name} (lavapipe, CPU)") } else { name }
}

/// Fails on the first message of the validation layer, where it is on.
pub fn validated(lab: &Lab) -> Result<(), Failure> {
    silent(&lab.validation_messages())
}

/// Fails on the first of the validation layer's messages.
pub fn silent(messages: &[String]) -> Result<(), Failure> {
    let failure = |first| Failure::other(format!("--validation found {} messages, the first: {first}", messages.len()));
    messages.first().map_or(Ok(()), |first| Err(failure(first)))
}
