//! What every frame of a run shows: camera, sun and time.

use crate::cli::args::BenchArgs;
use crate::cli::failure::Failure;
use crate::cli::measure::WARM_UP;
use glam::{DQuat, DVec3};
use umbrage::lab::{Lab, View};
use umbrage::view::{CameraPath, Surroundings, median_distance};
use umbrage::{Camera, Light};

/// Frames a second.
const RATE: f64 = 60.0;
/// Viewing distance over the diagonal of the scene's bounds where nothing is seen.
const FALLBACK_DISTANCE: f64 = 0.25;

/// The frames of a run, warm-up first.
pub struct Schedule {
    base: View,
    cameras: Vec<Camera>,
    sun_step_deg: f64,
    sun_axis: DVec3,
}

impl Schedule {
    /// Lays the path through the scene as it stands now.
    pub fn new(lab: &Lab, path: &CameraPath, args: &BenchArgs) -> Result<Self, Failure> {
        let base = lab.view().clone();
        let (scene, origin) = (lab.scene(), lab.scene().origin);
        let seen = median_distance(&*lab.gbuffer()?);
        let free = |from: DVec3, way: DVec3| !lab.tracer().occluded(from - origin, way, 1.0);
        let distance = seen.unwrap_or(FALLBACK_DISTANCE * scene.diagonal());
        let around = Surroundings { scene, distance, free: &free };
        let cameras = path.cameras(&base, &around, WARM_UP, args.frames, args.seed)?;
        Ok(Self { sun_axis: sun_axis(&base.lights), sun_step_deg: args.sun_rate / RATE, base, cameras })
    }

    /// The view that the run starts from.
    pub fn base(&self) -> &View {
        &self.base
    }

    /// Number of steps, warm-up and frames.
    pub fn steps(&self) -> u32 {
        self.cameras.len() as u32
    }

    /// The frame that a step shows; `None` in the warm-up, which shows frame 0.
    pub fn frame(step: u32) -> Option<u32> {
        step.checked_sub(WARM_UP)
    }

    /// Time of a frame in seconds.
    pub fn time_s(&self, frame: u32) -> f64 {
        self.base.time_s + f64::from(frame) / RATE
    }

    /// What a step shows; `None` after the last one.
    pub fn view(&self, step: u32) -> Option<View> {
        let frame = Self::frame(step).unwrap_or(0);
        let turn = DQuat::from_axis_angle(self.sun_axis, (f64::from(frame) * self.sun_step_deg).to_radians());
        Some(View {
            camera: *self.cameras.get(step as usize)?,
            lights: self.base.lights.iter().map(|light| turned(light, turn)).collect(),
            size: self.base.size,
            time_s: self.time_s(frame),
        })
    }
}

/// The horizontal direction across the first sun about which a positive turn lifts it; X for a sun in the zenith.
fn sun_axis(lights: &[Light]) -> DVec3 {
    let travel = lights.iter().find_map(|light| match light {
        Light::Directional { direction, .. } => Some(*direction),
        _ => None,
    });
    // the turn takes the horizontal part of the way to the sun, -travel, towards +Y
    travel.and_then(|travel| (-travel.normalize()).cross(DVec3::Y).try_normalize()).unwrap_or(DVec3::X)
}

fn turned(light: &Light, turn: DQuat) -> Light {
    match light {
        Light::Directional { direction, angular_diameter_deg } => {
            Light::Directional { direction: turn * *direction, angular_diameter_deg: *angular_diameter_deg }
        }
        other => other.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_positive_turn_lifts_the_sun_by_its_angle() {
        let light = Light::directional(DVec3::new(3.0, -4.0, 0.0));
        let axis = sun_axis(std::slice::from_ref(&light));
        assert_eq!(axis.y, 0.0);
        let Light::Directional { direction, .. } = turned(&light, DQuat::from_axis_angle(axis, 0.1)) else {
            panic!("another light");
        };
        let height = |d: DVec3| (-d.y / d.length()).asin();
        assert!((height(direction) - height(DVec3::new(3.0, -4.0, 0.0)) - 0.1).abs() < 1e-12);
        assert!((direction.length() - 5.0).abs() < 1e-12);
    }

    #[test]
    fn a_sun_in_the_zenith_turns_about_x() {
        assert_eq!(sun_axis(&[Light::directional(-DVec3::Y)]), DVec3::X);
    }
}
