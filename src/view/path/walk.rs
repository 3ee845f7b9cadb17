//! Walking and flying: along the horizon, turning back before walls and at the end of the scene.

use super::{Surroundings, beside, turned};
use crate::Camera;
use glam::{DQuat, DVec3};
use std::f64::consts::TAU;

/// Distance kept from walls, over the median viewing distance.
pub(super) const KEEP: f64 = 0.05;
/// Frames that turning back takes.
const TURN_FRAMES: u32 = 60;
/// Directions that must be free, in degrees from the one walked in.
const FEELERS_DEG: [f64; 3] = [-30.0, 0.0, 30.0];
/// Height above the scene where rising ends, over the diagonal of its bounds.
const CEILING: f64 = 0.1;

/// How somebody moves.
pub(super) struct Gait {
    /// Way in a frame over the median viewing distance.
    speed: f64,
    /// Way up over way forward.
    rise: f64,
    /// Looks this many degrees to either side.
    look_deg: f64,
    /// Frames from one look to the same side to the next.
    look_frames: f64,
}

impl Gait {
    pub(super) const WALK: Self = Self { speed: 0.0025, rise: 0.0, look_deg: 0.0, look_frames: 1.0 };
    pub(super) const FLY: Self = Self { speed: 0.01, rise: 0.1, look_deg: 25.0, look_frames: 240.0 };
}

pub(super) fn poses(base: &Camera, around: &Surroundings, gait: &Gait, frames: u32) -> Vec<Camera> {
    let up = base.up.normalize();
    let ceiling = super::super::corners(around.scene).map(|c| c.dot(up)).fold(base.eye.dot(up), f64::max)
        + CEILING * around.scene.diagonal();
    let (mut camera, mut turning, mut poses) = (*base, 0, Vec::with_capacity(frames as usize));
    for frame in 0..frames {
        let aside = gait.look_deg * (TAU * f64::from(frame) / gait.look_frames).sin();
        poses.push(turned(&camera, aside));
        if turning == 0 {
            let ahead = camera.target - camera.eye;
            let level = (ahead - up * ahead.dot(up)).normalize() * gait.speed * around.distance;
            let rising = level + up * (gait.rise * level.length());
            let steps = if camera.eye.dot(up) < ceiling { [rising, level] } else { [level, level] };
            match steps.into_iter().find(|&step| may_go(around, camera.eye, step, up)) {
                Some(step) => (camera.eye, camera.target) = (camera.eye + step, camera.target + step),
                None => turning = TURN_FRAMES,
            }
        }
        if turning > 0 {
            camera = turned(&camera, 180.0 / f64::from(TURN_FRAMES));
            turning -= 1;
        }
    }
    poses
}

/// Whether a step keeps its distance from walls and does not leave the scene.
fn may_go(around: &Surroundings, eye: DVec3, step: DVec3, up: DVec3) -> bool {
    let reach = step + step.normalize() * KEEP * around.distance;
    let outside = |p: DVec3| beside(around.scene, p, up);
    let feel = |deg: f64| (around.free)(eye, DQuat::from_axis_angle(up, deg.to_radians()) * reach);
    outside(eye + step) <= outside(eye) && FEELERS_DEG.into_iter().all(feel)
}
