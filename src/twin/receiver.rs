//! What a pixel's depth and packed receiver mean; single precision, in the order the shaders write it.

pub use crate::host::encode_normal;

use crate::gpu::structs::Frame;
use glam::{Vec2, Vec3, Vec4};

pub(super) fn xyz(v: [f32; 4]) -> Vec3 {
    Vec4::from(v).truncate()
}

/// Direction with unit depth through the centre of a pixel.
pub fn pixel_ray(frame: &Frame, pixel: [u32; 2]) -> Vec3 {
    let centre = Vec2::new(pixel[0] as f32 + 0.5, pixel[1] as f32 + 0.5);
    xyz(frame.ray_corner) + centre.x * xyz(frame.ray_dx) + centre.y * xyz(frame.ray_dy)
}

/// Distance along the view direction from a depth value of the camera's projection, the least that its rounding allows.
pub fn linear_depth(frame: &Frame, depth: f32) -> f32 {
    let at = frame.ray_corner[3] / (depth + frame.ray_dx[3]);
    let moved = at * at / frame.ray_corner[3].abs() * (frame.eye_low[3] + 1.2e-7 * depth.abs());
    at - (moved - 4.8e-7 * at).clamp(0.0, 0.5 * at)
}

/// Whether a depth value is that of a surface.
pub fn is_surface(frame: &Frame, depth: f32) -> bool {
    if frame.ray_corner[3] > 0.0 { depth > 0.0 } else { depth < 1.0 }
}

/// The unit vector that [`encode_normal`] packed.
pub fn decode_normal(word: u32) -> Vec3 {
    let fraction = |bits: u32| (f32::from(bits as u16 as i16) / 32767.0).clamp(-1.0, 1.0);
    let p = Vec2::new(fraction(word & 0xffff), fraction(word >> 16));
    let z = 1.0 - p.x.abs() - p.y.abs();
    let p = if z < 0.0 { fold(p) } else { p };
    p.extend(z).normalize()
}

fn fold(p: Vec2) -> Vec2 {
    let sign = |v: f32| if v >= 0.0 { 1.0 } else { -1.0 };
    Vec2::new((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y))
}

/// The value of a half float.
pub fn half(bits: u32) -> f32 {
    let (exponent, fraction) = (bits >> 10 & 31, (bits & 0x3ff) as f32);
    let magnitude = match exponent {
        0 => fraction * (-24f32).exp2(),
        31 if fraction == 0.0 => f32::INFINITY,
        31 => f32::NAN,
        e => (1024.0 + fraction) * (e as f32 - 25.0).exp2(),
    };
    if bits >> 15 & 1 == 1 { -magnitude } else { magnitude }
}

/// The half float next to zero from a finite value: its bits, rounded towards zero.
pub fn half_bits(value: f32) -> u32 {
    let sign = u32::from(value.is_sign_negative()) << 15;
    let magnitude = value.abs().min(65504.0);
    // halves are ordered as their bits are
    let (mut low, mut high) = (0u32, 0x7c00u32);
    while high - low > 1 {
        let middle = (low + high) / 2;
        if half(middle) <= magnitude { low = middle } else { high = middle }
    }
    sign | low
}

/// World-space derivatives of the receiver's plane per pixel, from the packed receiver.
pub fn decode_derivatives(frame: &Frame, receiver: [u32; 4], depth: f32) -> [Vec3; 2] {
    let pair = |word: u32| Vec2::new(half(word & 0xffff), half(word >> 16));
    let (a, b, c) = (pair(receiver[1]), pair(receiver[2]), pair(receiver[3]));
    let unit = depth * frame.ray_dy[3];
    [unit * a.extend(b.x), unit * Vec3::new(b.y, c.x, c.y)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_and_normals_survive() {
        for (bits, value) in
            [(0x3c00, 1.0), (0xc000, -2.0), (1, 5.960_464_5e-8), (0x7bff, 65504.0), (0, 0.0), (0x0400, 6.103_515_6e-5)]
        {
            assert_eq!((half(bits), half_bits(value)), (value, bits));
        }
        assert!(half(0x7c01).is_nan() && half(0x7c00).is_infinite());
        for n in [Vec3::X, Vec3::NEG_Z, Vec3::new(0.3, -0.8, -0.2).normalize(), Vec3::new(-0.6, 0.1, 0.7).normalize()] {
            assert!(decode_normal(encode_normal(n)).distance(n) < 1e-4, "{n}");
        }
    }
}
