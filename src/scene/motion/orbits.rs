//! Movers for scenes without an animation: knots that circle in front of the camera.

use super::{Kind, Motion, Shape};
use crate::scene::Scene;
use crate::scene::assemble::{Bounds, EMPTY, Part, add, union};
use crate::scene::builtin::knot;
use crate::scene::materials::plain;
use glam::{DAffine3, DMat3, DQuat, DVec3};
use std::f64::consts::TAU;

/// Seconds of one round.
pub(super) const PERIOD_S: f64 = 4.0;
/// Rounds that the slow mover takes for one turn.
pub(super) const SLOW_PERIODS: f64 = 4.0;
/// Most movers that are added.
const MOST: u32 = 4096;
/// Radius of a mover in lengths of the distance from the eye to the target.
const RADIUS: f64 = 0.02;
/// Least and largest distance from the eye, in the same lengths.
const DEPTH: [f64; 2] = [0.45, 0.85];
/// In lengths of a mover's own distance from the eye: how far to the side, up, and up at most to stay above the target;
/// radius of the orbit along and up. All of it lies within 19 degrees of the line of sight.
const SIDE: f64 = 0.19;
const UP: f64 = 0.14;
const MOST_UP: f64 = 0.22;
const ORBIT: [f64; 2] = [0.06, 0.03];

/// A closed path and turns around an axis.
pub(super) struct Orbit {
    centre: DVec3,
    /// Half axes of the path, and how it sways twice a round.
    axes: [DVec3; 3],
    phase: f64,
    turn_axis: DVec3,
    turns_per_period: f64,
}

impl Orbit {
    /// World matrix at a time in seconds.
    pub(super) fn at(&self, time_s: f64) -> DAffine3 {
        // reduced first, so that late times are as smooth as early ones
        let rounds = time_s.rem_euclid(PERIOD_S * SLOW_PERIODS) / PERIOD_S;
        let (sin, cos) = (TAU * (rounds + self.phase)).sin_cos();
        let [u, v, sway] = self.axes;
        let place = self.centre + u * cos + v * sin + sway * (2.0 * sin * cos);
        let turn = DQuat::from_axis_angle(self.turn_axis, TAU * (rounds * self.turns_per_period + self.phase));
        DAffine3::from_rotation_translation(turn, place)
    }

    fn bounds(&self, radius: f64) -> Bounds {
        let [u, v, sway] = self.axes;
        let path = (u * u + v * v).map(f64::sqrt) + sway.abs();
        // single precision moves vertices a little
        let reach = path + 1.001 * radius + 1e-6 * self.centre.abs().max_element();
        (self.centre - reach, self.centre + reach)
    }
}

impl Motion {
    /// Adds `count` movers to a scene and returns what moves them: opaque knots of 5,000 triangles, one mesh, as large as
    /// 4 % of the distance from `eye` to `target` (world space).
    ///
    /// They circle between the two in 4 s, right, left and above the line of sight, above the target where a field of view
    /// of 40 degrees leaves room for that; the first stays in place and turns once in 16 s. They stand as at time 0. The
    /// scene's bounds grow to hold at all times while its origin stays, which then is not the middle of the bounds. At
    /// most 4,096 are added. The same arguments give the same movers.
    pub fn synthetic(scene: &mut Scene, eye: DVec3, target: DVec3, count: u32, seed: u64) -> Self {
        let count = count.min(MOST);
        let frame = Frame::new(scene, eye, target);
        let radius = RADIUS * frame.distance;
        let mut random = Random(seed);
        let orbits: Vec<Orbit> = (0..count).map(|i| frame.orbit(i, &mut random, target.y, radius)).collect();
        let first = scene.instances.len() as u32;
        if !orbits.is_empty() {
            let shape = knot(radius);
            let material = scene.materials.len() as u32;
            scene.materials.push(plain([0.55, 0.22, 0.08, 1.0]));
            let part = Part {
                positions: shape.positions,
                attributes: shape.attributes,
                triangles: shape.triangles,
                material,
                casts: true,
                alpha_tested: false,
                instances: orbits.iter().map(|o| o.at(0.0)).collect(),
                group: 0,
                moves: None,
            };
            add(scene, part);
            let all = orbits.iter().map(|o| o.bounds(radius)).fold(EMPTY, union);
            (scene.bounds_min, scene.bounds_max) = union((scene.bounds_min, scene.bounds_max), all);
        }
        Self { kind: Kind::Orbits { first, orbits }, shape: Shape::of(scene) }
    }
}

/// Where the camera stands and looks.
struct Frame {
    eye: DVec3,
    distance: f64,
    /// Right, up, forward.
    axes: DMat3,
}

impl Frame {
    /// Arguments without a direction are replaced: by the scene's middle, seen from outside.
    fn new(scene: &Scene, eye: DVec3, target: DVec3) -> Self {
        let distance = (target - eye).length();
        let usable = distance > 0.0 && distance.is_finite();
        let size = scene.diagonal().max(1e-3);
        let (eye, distance, forward) = match usable {
            true => (eye, distance, (target - eye) / distance),
            false => (0.5 * (scene.bounds_min + scene.bounds_max) + DVec3::Z * size, size, DVec3::NEG_Z),
        };
        let right = forward.cross(DVec3::Y).try_normalize().unwrap_or(DVec3::X);
        Self { eye, distance, axes: DMat3::from_cols(right, right.cross(forward), forward) }
    }

    fn orbit(&self, number: u32, random: &mut Random, floor: f64, radius: f64) -> Orbit {
        let depth = self.distance * random.between(DEPTH[0], DEPTH[1]);
        // golden sections fill the width evenly, whatever the count
        let side = 2.0 * (0.5 + f64::from(number) * 0.618_033_988_749_895).fract() - 1.0;
        let mut up = depth * random.between(0.0, UP);
        let [right, above, _] = self.axes.to_cols_array_2d().map(DVec3::from);
        let (sin, cos) = (TAU * random.unit()).sin_cos();
        let level = DVec3::new(right.x, 0.0, right.z).try_normalize().unwrap_or(DVec3::X);
        let along = level * cos + level.cross(DVec3::Y) * sin;
        let axes = match number {
            0 => [DVec3::ZERO; 3],
            _ => [along, along.cross(DVec3::Y) * 0.6, DVec3::Y].map(|axis| axis * depth),
        };
        let axes = [axes[0] * ORBIT[0], axes[1] * ORBIT[0], axes[2] * ORBIT[1]];
        let at = |up: f64| self.eye + self.axes * DVec3::new(side * SIDE * depth, up, depth);
        let missing = floor + radius + ORBIT[1] * depth - at(up).y;
        if missing > 0.0 && above.y > 1e-3 {
            up = (up + missing / above.y).min(MOST_UP * depth).max(up);
        }
        let axis = DVec3::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0), random.between(-1.0, 1.0));
        Orbit {
            centre: at(up),
            axes,
            phase: random.unit(),
            turn_axis: axis.try_normalize().unwrap_or(DVec3::Y),
            turns_per_period: if number == 0 { 1.0 / SLOW_PERIODS } else { 1.0 },
        }
    }
}

/// Numbers from a seed (splitmix64).
struct Random(u64);

impl Random {
    /// From 0 to below 1.
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ z >> 31) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}
