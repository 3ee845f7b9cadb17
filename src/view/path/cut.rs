//! Cuts: a few viewpoints around the base view, each shown for some frames. They look to other sides from where the base
//! view stands, or from other sides at what it sees where it stands beside the scene.

use super::{Surroundings, beside, random, turned, walk::KEEP};
use crate::Camera;
use glam::{DQuat, DVec3};

/// Frames between jumps.
const STAY: u32 = 12;
/// Number of viewpoints; the first is the base view.
const VIEWPOINTS: u32 = 4;
/// Degrees by which a viewpoint's turn differs from a multiple of a quarter, at most.
const SCATTER_DEG: f64 = 15.0;
/// Way from the base view over the median viewing distance, at most.
const WAY: f64 = 0.15;
/// Places tried before a viewpoint stays at the base view's eye.
const TRIES: u32 = 16;
/// Directions in which a place must be free.
const FEELERS: u32 = 8;

pub(super) fn poses(base: &Camera, around: &Surroundings, frames: u32, seed: u64) -> Vec<Camera> {
    let viewpoints: Vec<Camera> = (0..VIEWPOINTS).map(|k| viewpoint(base, around, k, seed)).collect();
    (0..frames).map(|frame| viewpoints[(frame / STAY % VIEWPOINTS) as usize]).collect()
}

fn viewpoint(base: &Camera, around: &Surroundings, k: u32, seed: u64) -> Camera {
    if k == 0 {
        return *base;
    }
    // numbers that the jitter, which counts from 0, does not reach
    let draw = |i: u32| random(!seed, u64::from(k * (2 * TRIES + 1) + i));
    let quarter = 360.0 / f64::from(VIEWPOINTS);
    let turn_deg = f64::from(k) * quarter + 2.0 * SCATTER_DEG * draw(0);
    let up = base.up.normalize();
    let camera = if beside(around.scene, base.eye, up) > 0.0 {
        let back = around.distance * (base.eye - base.target).normalize();
        let pivot = base.eye - back;
        let eye = pivot + DQuat::from_axis_angle(up, turn_deg.to_radians()) * back;
        let way = eye - base.eye;
        turned(&Camera { eye, target: base.target + way, ..*base }, turn_deg)
    } else {
        turned(base, turn_deg)
    };
    let side = up.any_orthonormal_vector();
    let around_up = |turns: f64| DQuat::from_axis_angle(up, turns * std::f64::consts::TAU) * side;
    let keep = KEEP * around.distance;
    let way = |attempt: u32| {
        let length = WAY * around.distance * (1.0 + draw(2 * attempt + 2)) / 1.5;
        around_up(draw(2 * attempt + 1)) * length
    };
    let clear = |way: &DVec3| {
        let feel = |i: u32| (around.free)(camera.eye + *way, around_up(f64::from(i) / f64::from(FEELERS)) * keep);
        (around.free)(camera.eye, *way) && (0..FEELERS).all(feel)
    };
    let way = (0..TRIES).map(way).find(clear).unwrap_or(DVec3::ZERO);
    Camera { eye: camera.eye + way, target: camera.target + way, ..camera }
}
