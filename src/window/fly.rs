//! A camera that flies, and a sun that turns.

use super::keys::Held;
use crate::{Camera, Light};
use glam::{DQuat, DVec3};

/// Seconds to cross the scene's diagonal.
const CROSSING_S: f64 = 15.0;
/// Speed with shift over that without.
const FAST: f64 = 4.0;
/// Growth of the speed for a step of the wheel.
const WHEEL: f64 = 1.25;
/// Steepest look up and down, in degrees.
const STEEPEST_DEG: f64 = 89.0;
/// Degrees a second by which keys turn the sun.
const SUN_DEG_PER_S: f64 = 30.0;
/// Height of the sun in degrees.
const SUN_HEIGHTS_DEG: [f64; 2] = [1.0, 89.0];

/// The camera of the window: it keeps its up direction.
pub(super) struct Fly {
    camera: Camera,
    /// World units a second.
    pub(super) speed: f64,
}

impl Fly {
    /// `diagonal`: of the scene.
    pub(super) fn new(camera: Camera, diagonal: f64) -> Self {
        // who flies away from the scene still sees it
        let far = camera.far.max(3.0 * diagonal);
        let camera = Camera { up: camera.up.normalize_or(DVec3::Y), far, ..camera };
        Self { camera, speed: (diagonal / CROSSING_S).max(1e-9) }
    }

    pub(super) fn camera(&self) -> Camera {
        self.camera
    }

    pub(super) fn wheel(&mut self, steps: f64) {
        self.speed = (self.speed * WHEEL.powf(steps)).clamp(1e-9, 1e9);
    }

    /// Moves for a time.
    pub(super) fn advance(&mut self, held: Held, dt_s: f64) {
        let forward = (self.camera.target - self.camera.eye).normalize();
        let right = forward.cross(self.camera.up).normalize();
        let along = |a: Held, b: Held| f64::from(i8::from(held.has(a)) - i8::from(held.has(b)));
        let direction = forward * along(Held::FORWARD, Held::BACK)
            + right * along(Held::RIGHT, Held::LEFT)
            + self.camera.up * along(Held::UP, Held::DOWN);
        let step = direction * self.speed * if held.has(Held::FAST) { FAST } else { 1.0 } * dt_s;
        self.camera.eye += step;
        self.camera.target += step;
    }

    /// Looks to where the mouse goes, by as much as the picture's middle would move. Pixels right and down; `height` of the
    /// picture.
    pub(super) fn look(&mut self, pixels: [f64; 2], height: u32) {
        let radians = self.camera.fov_y_deg.to_radians() / f64::from(height.max(1));
        let forward = self.camera.target - self.camera.eye;
        let turned = turn(forward, self.camera.up, pixels.map(|p| -p * radians), [-STEEPEST_DEG, STEEPEST_DEG]);
        self.camera.target = self.camera.eye + turned;
    }
}

/// `v` turned about `up` and towards it, by `angles` in radians, not beyond heights above the horizon in degrees.
fn turn(v: DVec3, up: DVec3, [around, rise]: [f64; 2], [low, high]: [f64; 2]) -> DVec3 {
    let height = (v.normalize().dot(up)).clamp(-1.0, 1.0).asin();
    // what is beyond the bounds already is not moved farther out
    let (low, high) = (low.to_radians().min(height), high.to_radians().max(height));
    let rise = (height + rise).clamp(low, high) - height;
    let side = v.cross(up).normalize_or(up.any_orthonormal_vector());
    DQuat::from_axis_angle(up, around) * (DQuat::from_axis_angle(side, rise) * v)
}

/// The light's direction with the sun moved by degrees to the right and up, as one who faces it sees it.
pub(super) fn turn_sun(direction: DVec3, up: DVec3, [right, rise]: [f64; 2]) -> DVec3 {
    -turn(-direction, up, [-right.to_radians(), rise.to_radians()], SUN_HEIGHTS_DEG)
}

/// Degrees to the right and up by which held keys turn the sun in a time.
pub(super) fn sun_step(held: Held, dt_s: f64) -> Option<[f64; 2]> {
    let along = |a: Held, b: Held| f64::from(i8::from(held.has(a)) - i8::from(held.has(b)));
    let step = [along(Held::SUN_RIGHT, Held::SUN_LEFT), along(Held::SUN_UP, Held::SUN_DOWN)];
    (step != [0.0; 2]).then(|| step.map(|s| s * SUN_DEG_PER_S * dt_s))
}

/// The first directional light.
pub(super) fn sun(lights: &mut [Light]) -> Option<&mut DVec3> {
    lights.iter_mut().find_map(|light| match light {
        Light::Directional { direction, .. } => Some(direction),
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fly() -> Fly {
        let camera =
            Camera { eye: DVec3::ZERO, target: -DVec3::Z, up: 2.0 * DVec3::Y, fov_y_deg: 60.0, near: 0.1, far: 10.0 };
        Fly::new(camera, 150.0)
    }

    #[test]
    fn keys_move_along_the_camera_s_axes() {
        for (held, want) in [
            (Held::FORWARD, -DVec3::Z),
            (Held::BACK, DVec3::Z),
            (Held::RIGHT, DVec3::X),
            (Held::LEFT, -DVec3::X),
            (Held::UP, DVec3::Y),
            (Held::DOWN, -DVec3::Y),
        ] {
            let mut fly = fly();
            fly.advance(held, 0.1);
            assert!((fly.camera().eye - want).length() < 1e-12, "{held:?}: {}", fly.camera().eye);
            assert!((fly.camera().target - want + DVec3::Z).length() < 1e-12, "{held:?}");
        }
        let mut fast = fly();
        let mut held = Held::default();
        [Held::FORWARD, Held::FAST].into_iter().for_each(|key| held.set(key, true));
        fast.advance(held, 0.1);
        assert!((fast.camera().eye.z + FAST).abs() < 1e-12);
    }

    #[test]
    fn the_camera_looks_to_where_the_mouse_goes() {
        let mut fly = fly();
        fly.look([10.0, 0.0], 600);
        assert!((fly.camera().target.x - 1.0f64.to_radians().sin()).abs() < 1e-12, "{}", fly.camera().target);
        fly.look([0.0, -1e5], 600);
        let steep = fly.camera().target.y;
        assert!((steep - STEEPEST_DEG.to_radians().sin()).abs() < 1e-9, "{steep}");
        assert!((fly.camera().target.length() - 1.0).abs() < 1e-9);
    }

    #[test]
    fn the_sun_stays_above_the_horizon() {
        let low = turn_sun(DVec3::new(1.0, -1.0, 0.0), DVec3::Y, [0.0, -90.0]).normalize();
        assert!((low.y + 1.0f64.to_radians().sin()).abs() < 1e-9, "{low}");
        // the sun in the west, seen by one who faces it, moves right: to the north
        let right = turn_sun(DVec3::new(1.0, -1.0, 0.0), DVec3::Y, [90.0, 0.0]);
        assert!((right - DVec3::new(0.0, -1.0, 1.0)).length() < 1e-9, "{right}");
    }

    #[test]
    fn opposite_keys_cancel() {
        let mut held = Held::default();
        [Held::SUN_UP, Held::SUN_DOWN].into_iter().for_each(|key| held.set(key, true));
        assert_eq!(sun_step(held, 1.0), None);
        assert_eq!(sun_step(Held::SUN_LEFT, 0.1), Some([-3.0, 0.0]));
    }
}
