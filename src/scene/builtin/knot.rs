//! A body that casts a rich shadow: a bumpy trefoil knot.

use super::shapes::{Shape, sheet};
use glam::DVec3;
use std::f64::consts::TAU;

/// Cells along and around the tube: 5,000 triangles.
const CELLS: [u32; 2] = [125, 20];

/// A closed tube along a trefoil knot around zero; no point lies further away than `radius`.
pub(in crate::scene) fn knot(radius: f64) -> Shape {
    // the seams must close exactly
    let angle = |t: f64| if t < 1.0 { t * TAU } else { 0.0 };
    let mut shape = sheet(CELLS[0], CELLS[1], |u, v| {
        let (along, around) = (angle(u), angle(v));
        let line = centre_line(along);
        let step = 1e-4;
        let ahead = (centre_line(along + step) - centre_line(along - step)).normalize();
        let out = ahead.cross(DVec3::Y).normalize();
        let thickness = 0.42 * (1.0 + 0.18 * (15.0 * along).sin() * (3.0 * around).cos());
        line + thickness * (out * around.cos() + ahead.cross(out) * around.sin())
    });
    let longest = shape.positions.iter().map(|p| p.length()).fold(0.0, f64::max);
    shape.positions.iter_mut().for_each(|p| *p *= radius / longest);
    shape
}

/// The knot winds twice around the y axis and three times around the ring.
fn centre_line(angle: f64) -> DVec3 {
    let ring = 2.0 + (3.0 * angle).cos();
    DVec3::new(ring * (2.0 * angle).cos(), (3.0 * angle).sin(), ring * (2.0 * angle).sin())
}
