//! Camera paths: where the camera stands in every frame of a run, at 60 frames a second.

mod cut;
mod keys;
mod walk;

pub use keys::PathFile;

use super::{ViewError, depth_range};
use crate::Camera;
use crate::lab::View;
use crate::scene::Scene;
use crate::truth::GBuffer;
use glam::{DQuat, DVec3};
use walk::Gait;

/// The paths that have a name; `teleport` is another word for `cut`.
pub const PATH_NAMES: [&str; 7] = ["still", "walk", "turn", "fly", "cut", "teleport", "zoom"];

/// Degrees that `turn` turns in a frame.
const TURN_DEG: f64 = 0.75;
/// Share of the field of view that `zoom` leaves in the middle of the run.
const ZOOM: f64 = 1.0 / 8.0;

/// How the camera moves, relative to the view that the run starts with.
#[derive(Debug, Clone, PartialEq)]
pub enum CameraPath {
    /// Stands; turned anew in each frame by up to half a pixel in x and in y.
    Still,
    /// Forward along the horizon by 0.25 % of the median viewing distance a frame, turning back before walls.
    Walk,
    /// Turns about the up direction by 0.75 degrees a frame.
    Turn,
    /// Four times as fast as `Walk`, rising by a tenth, looking to both sides.
    Fly,
    /// Jumps every 12 frames to the next of four viewpoints, and stands like `Still` between. They differ by about 90
    /// degrees and a short way; from beside the scene they go around what is seen.
    Cut,
    /// The field of view falls exponentially to an eighth at the middle of the run and returns.
    Zoom,
    /// Linear between the keys of a file.
    Keys(PathFile),
}

/// What a path must know of the scene around it.
pub struct Surroundings<'a> {
    /// The scene, for its bounds.
    pub scene: &'a Scene,
    /// Median distance from the eye to what it sees, in world units.
    pub distance: f64,
    /// Whether nothing lies between a point in world space and that point plus a vector.
    pub free: &'a dyn Fn(DVec3, DVec3) -> bool,
}

impl CameraPath {
    /// The path of that name, one of [`PATH_NAMES`].
    pub fn named(name: &str) -> Option<Self> {
        Some(match name {
            "still" => Self::Still,
            "walk" => Self::Walk,
            "turn" => Self::Turn,
            "fly" => Self::Fly,
            "cut" | "teleport" => Self::Cut,
            "zoom" => Self::Zoom,
            _ => return None,
        })
    }

    /// The cameras of `warm_up + frames` frames; the first `warm_up` stand where frame 0 does, only that jitter goes on.
    ///
    /// All have the same near and far plane, which hold the scene in every frame. The same arguments give the same path.
    ///
    /// # Errors
    /// A frame's camera is not allowed, as [`View::check`] says; `base` must have passed that.
    pub fn cameras(
        &self,
        base: &View,
        around: &Surroundings,
        warm_up: u32,
        frames: u32,
        seed: u64,
    ) -> Result<Vec<Camera>, ViewError> {
        let poses = self.poses(&base.camera, around, frames, seed);
        let mut cameras = Vec::with_capacity((warm_up + frames) as usize);
        for step in 0..warm_up + frames {
            let frame = step.saturating_sub(warm_up) as usize;
            let Some(&pose) = poses.get(frame) else { break };
            let jitters = matches!(self, Self::Still | Self::Cut);
            cameras.push(if jitters { jittered(pose, base.size[1], seed, step) } else { pose });
        }
        let [least, far] = depth_range(&base.camera, around.scene);
        let near = base.camera.near.min(least);
        let far = cameras.iter().map(|camera| depth_range(camera, around.scene)[1]).fold(far, f64::max);
        for (step, camera) in cameras.iter_mut().enumerate() {
            (camera.near, camera.far) = (near, far.max(base.camera.far));
            let frame = step.saturating_sub(warm_up as usize);
            let view = View { camera: *camera, ..base.clone() };
            let refuse = |what| ViewError { file: self.name(), what: format!("at frame {frame} {what}") };
            view.check().map_err(refuse)?;
        }
        Ok(cameras)
    }

    fn poses(&self, base: &Camera, around: &Surroundings, frames: u32, seed: u64) -> Vec<Camera> {
        let each = |pose: &dyn Fn(u32) -> Camera| (0..frames).map(pose).collect();
        match self {
            Self::Still => each(&|_| *base),
            Self::Walk => walk::poses(base, around, &Gait::WALK, frames),
            Self::Turn => each(&|frame| turned(base, f64::from(frame) * TURN_DEG)),
            Self::Fly => walk::poses(base, around, &Gait::FLY, frames),
            Self::Cut => cut::poses(base, around, frames, seed),
            Self::Zoom => each(&|frame| {
                let share = f64::from(frame) / f64::from(frames.saturating_sub(1).max(1));
                let depth = 1.0 - (2.0 * share - 1.0).abs();
                Camera { fov_y_deg: base.fov_y_deg * ZOOM.powf(depth), ..*base }
            }),
            Self::Keys(file) => each(&|frame| file.pose(base, frame)),
        }
    }

    fn name(&self) -> String {
        match self {
            Self::Keys(file) => file.name().to_owned(),
            named => format!("path {named:?}").to_lowercase(),
        }
    }
}

/// Median distance of the surfaces from the eye that sees them; `None` when it sees none.
pub fn median_distance(gbuffer: &GBuffer) -> Option<f64> {
    let surfaces = gbuffer.position.iter().zip(&gbuffer.hit).filter(|(_, hit)| **hit);
    let mut distances: Vec<f64> = surfaces.map(|(p, _)| DVec3::from(p.map(f64::from)).length()).collect();
    distances.sort_by(f64::total_cmp);
    distances.get(distances.len() / 2).copied()
}

/// How far a point lies outside of the scene's bounds, to the sides only.
fn beside(scene: &Scene, point: DVec3, up: DVec3) -> f64 {
    let out = point - point.clamp(scene.bounds_min, scene.bounds_max);
    (out - up * out.dot(up)).length()
}

/// The camera turned to the left about its up direction.
fn turned(camera: &Camera, angle_deg: f64) -> Camera {
    let turn = DQuat::from_axis_angle(camera.up.normalize(), angle_deg.to_radians());
    Camera { target: camera.eye + turn * (camera.target - camera.eye), ..*camera }
}

/// The camera turned by less than half a pixel in x and in y.
fn jittered(camera: Camera, height: u32, seed: u64, step: u32) -> Camera {
    let view = camera.view_from_world();
    let pixel = 2.0 * (0.5 * camera.fov_y_deg).to_radians().tan() / f64::from(height);
    let [x, y] = [0, 1].map(|axis| random(seed, 2 * u64::from(step) + axis) * pixel);
    let aside = view.row(0) * x + view.row(1) * y;
    Camera { target: camera.target + aside * camera.eye.distance(camera.target), ..camera }
}

/// A number from -0.5 to below 0.5 for each seed and index: the finaliser of splitmix64.
pub(super) fn random(seed: u64, index: u64) -> f64 {
    let mut x = seed.wrapping_add(index.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 53) as f64 - 0.5
}
