//! The receiver's plane of every pixel, in double precision.
//!
//! The GPU's result is right when the normal's word is the same and each derivative is at most one unit of its half
//! float away from the true value, plus what single precision may lose on the way: Vulkan leaves divisions 2.5 units and
//! `inversesqrt` 2 units of room, and grazing planes divide by a difference that is nearly zero. [`Plane::tolerance`]
//! holds the sum.

use super::receiver::{decode_normal, half, half_bits, is_surface, pixel_ray, xyz};
use crate::gpu::structs::Frame;

/// Largest derivative that is stored.
const LIMIT: f64 = 65000.0;

/// The plane of one pixel.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Plane {
    /// The normal as given; 0 where there is no surface.
    pub normal: u32,
    /// dx and dy in world space, divided by depth and the length of a pixel's step.
    pub derivatives: [f64; 6],
    /// How far from them a result may be.
    pub tolerance: [f64; 6],
}

/// A packed receiver's derivatives.
pub fn unpack(receiver: [u32; 4]) -> [f64; 6] {
    std::array::from_fn(|i| f64::from(half(receiver[1 + i / 2] >> (16 * (i % 2)) & 0xffff)))
}

/// Distance from a value to the next half float away from zero.
fn half_unit(value: f64) -> f64 {
    let bits = half_bits(value.abs() as f32);
    f64::from(half(bits + 1)) - f64::from(half(bits))
}

/// The planes of all pixels, row by row.
pub fn gradient(frame: &Frame, depth: &[f32], normal: &[u32]) -> Vec<Plane> {
    let width = frame.size[0];
    let plane = |i: usize| {
        if !is_surface(frame, depth[i]) {
            return Plane::default();
        }
        let n = decode_normal(normal[i]).as_dvec3().normalize();
        let ray = pixel_ray(frame, [i as u32 % width, i as u32 / width]).as_dvec3();
        let steps = [xyz(frame.ray_dx), xyz(frame.ray_dy)].map(|s| s.as_dvec3());
        let along = n.dot(ray).min(-1e-6 * ray.length());
        let inverse = 1.0 / (along * f64::from(frame.ray_dy[3]));
        let rounding = 8.0 * f64::from(f32::EPSILON);
        let mut result = Plane { normal: normal[i], ..Plane::default() };
        for (s, step) in steps.into_iter().enumerate() {
            let exact = (step * along - ray * n.dot(step)) * inverse;
            let lost = (step.abs() * ray.length() + ray.abs() * step.length()) * inverse.abs();
            let lost = rounding * (lost + exact.abs() * (ray.length() / along.abs()));
            for axis in 0..3 {
                let value = exact[axis].clamp(-LIMIT, LIMIT);
                result.derivatives[3 * s + axis] = value;
                result.tolerance[3 * s + axis] = half_unit(value) + lost[axis];
            }
        }
        result
    };
    (0..depth.len()).map(plane).collect()
}
