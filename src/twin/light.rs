//! Where a receiver lies as a light sees it: `glsl/shared/light.glsl` in single precision, in the order of the shader.

use super::ROOT_LEVEL;
use super::receiver::xyz;
use crate::gpu::structs::{Frame, LightRecord, light_kind};
use glam::{Vec2, Vec3};

/// Level-0 pages from the middle of a face to its side.
const HALF: i32 = 1 << (ROOT_LEVEL - 1);

/// A receiver as a light sees it, with what rounding may change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Receiver {
    /// Face of the light.
    pub face: u32,
    /// Position in sides of a level-0 page from `page`, before whole pages are taken off.
    pub units: Vec2,
    /// Level-0 page that `units` counts from.
    pub page: [i32; 2],
    /// Squared footprint of the level rule, projected, before the rule's factor.
    pub squared: f32,
    /// By how much rounding may change `squared`.
    pub room: f32,
    /// Length in units of the longest sum that made `units`.
    pub reach: f32,
    /// Cosine-like margins of the tests that admitted it; near zero rounding may decide otherwise.
    pub margin: f32,
}

fn light_axes(light: &LightRecord, v: Vec3) -> Vec3 {
    Vec3::new(xyz(light.axis_x).dot(v), xyz(light.axis_y).dot(v), xyz(light.axis_z).dot(v))
}

fn face_axes(face: u32, v: Vec3) -> Vec3 {
    match face {
        1 => Vec3::new(-v.x, v.y, -v.z),
        2 => Vec3::new(-v.z, v.y, v.x),
        3 => Vec3::new(v.z, v.y, -v.x),
        4 => Vec3::new(v.x, -v.z, v.y),
        5 => Vec3::new(v.x, v.z, -v.y),
        _ => v,
    }
}

fn cube_face(v: Vec3) -> u32 {
    let a = v.abs();
    let pick = |v: f32, face: u32| if v >= 0.0 { face } else { face + 1 };
    if a.z >= a.x && a.z >= a.y {
        pick(v.z, 0)
    } else if a.x >= a.y {
        pick(v.x, 2)
    } else {
        pick(v.y, 4)
    }
}

/// The receiver, whether or not the light reaches it: then `margin` is negative. `None` without a light.
pub fn receiver(
    frame: &Frame,
    light: &LightRecord,
    from_eye: Vec3,
    n: Vec3,
    derivatives: [Vec3; 2],
) -> Option<Receiver> {
    let [axis_dx, axis_dy] = derivatives.map(|d| light_axes(light, d));
    // each coordinate may lose a few units of the vector's length
    let lost = derivatives.map(|d| 4.0 * f32::EPSILON * d.length());
    if light.kind[0] == light_kind::NONE {
        return None;
    }
    if light.kind[0] == light_kind::DIRECTIONAL {
        let ls = light_axes(light, from_eye).truncate();
        let [page_x, page_y, ..] = light.eye_page;
        let (squared, room) = footprint(frame, axis_dx.truncate(), axis_dy.truncate(), lost);
        return Some(Receiver {
            face: 0,
            units: Vec2::new(light.axis_x[3], light.axis_y[3]) + ls * light.scale[0],
            page: [page_x, page_y],
            squared,
            room,
            reach: from_eye.length() * light.scale[0],
            margin: -light_axes(light, n).z,
        });
    }
    let q = from_eye + xyz(light.eye);
    let length = q.length();
    let at = light_axes(light, q);
    let cone = at.z / length - light.eye[3];
    let margin = (-n.dot(q) / length).min(1.0 - length / light.place[3]).min(cone);
    let face = if light.kind[0] == light_kind::CUBE { cube_face(at) } else { 0 };
    let [at, axis_dx, axis_dy] = [at, axis_dx, axis_dy].map(|v| face_axes(face, v));
    let inverse = 1.0 / at.z;
    let projected = (at.truncate() * inverse).clamp(Vec2::NEG_ONE, Vec2::ONE);
    let slide = |d: Vec3| (d.truncate() - projected * d.z) * inverse;
    let tan = light.axis_x[3].sqrt();
    let lost = lost.map(|l| 4.0 * l * inverse / tan);
    let (squared, room) = footprint(frame, slide(axis_dx), slide(axis_dy), lost);
    Some(Receiver {
        face,
        units: projected * light.scale[0],
        page: [HALF; 2],
        squared,
        room,
        reach: (from_eye.length() + xyz(light.eye).length()) * inverse / tan * light.scale[0],
        margin,
    })
}

/// The squared footprint of the level rule, and by how much rounding may change it.
fn footprint(frame: &Frame, dx: Vec2, dy: Vec2, lost: [f32; 2]) -> (f32, f32) {
    let (squared, room) = match frame.size[2] {
        0 => ((dx.x * dy.y - dx.y * dy.x).abs(), dx.length() * lost[1] + dy.length() * lost[0]),
        _ => (
            (dx.x * dx.x + dx.y * dx.y).min(dy.x * dy.x + dy.y * dy.y),
            (2.0 * dx.length() * lost[0]).max(2.0 * dy.length() * lost[1]) + lost[0].max(lost[1]).powi(2),
        ),
    };
    (squared, super::request::NEAR * squared + room)
}

/// The level of a squared footprint.
pub fn level(light: &LightRecord, squared: f32) -> i32 {
    let exponent = ((squared.max(0.0) * light.rule[0]).to_bits() >> 23 & 255) as i32 - 127;
    (exponent >> 1).clamp(light.kind[3] as i32, ROOT_LEVEL)
}

/// The level of a squared footprint and the weight of the next coarser one where levels are blended: it grows linearly with
/// the squared footprint over its last octave before the next level.
pub fn blend(light: &LightRecord, squared: f32) -> (i32, f64) {
    let level = level(light, squared);
    // squared texels of the level: 1 to 4
    let ratio = f64::from(squared.max(0.0) * light.rule[0]) / 4f64.powi(level);
    let within = level < ROOT_LEVEL && (1.0..4.0).contains(&ratio);
    (level, if within { (0.5 * ratio - 1.0).max(0.0) } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn blended_levels_have_no_step() {
        let mut light = LightRecord::zeroed();
        (light.rule[0], light.kind[3]) = (1.0, 2);
        let place = |squared: f32| blend(&light, squared);
        let exact = [(1.0, (2, 0.0)), (16.0, (2, 0.0)), (32.0, (2, 0.0)), (48.0, (2, 0.5)), (64.0, (3, 0.0))];
        assert!(exact.iter().all(|&(squared, want)| place(squared) == want));
        let steps = (0..20_000).map(|i| (0.001 * i as f32).exp2());
        let places: Vec<f64> = steps.map(place).map(|(level, weight)| f64::from(level) + weight).collect();
        assert!(places.windows(2).all(|w| (0.0..0.002).contains(&(w[1] - w[0]))));
    }

    #[test]
    fn faces_are_rotations_that_bring_their_side_to_the_front() {
        let fronts = [Vec3::Z, Vec3::NEG_Z, Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y];
        for (face, front) in (0..).zip(fronts) {
            assert_eq!((cube_face(front), face_axes(face, front)), (face, Vec3::Z));
            let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| face_axes(face, axis));
            assert_eq!(x.cross(y), z, "face {face} mirrors");
        }
    }
}
