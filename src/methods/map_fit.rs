//! Fits that need no look at the samples (book, 4.1), computed in double precision.

use crate::gpu::structs::Fit;
use crate::lab::View;
use bytemuck::Zeroable;
use glam::{DVec2, DVec3};

/// Rotations of a map that are tried, over a quarter turn.
pub(super) const ANGLES: u32 = 16;

/// [`Fit::row_w`] of a map that is not warped.
const UNWARPED: [f32; 4] = [0.0, 0.0, 1.0, 0.0];

/// A box relative to the scene's origin: lower and upper corner.
pub(super) type Bounds = [DVec3; 2];

pub(super) fn box_corners([low, high]: Bounds) -> [DVec3; 8] {
    std::array::from_fn(|i| {
        let pick = |axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
        DVec3::new(pick(0), pick(1), pick(2))
    })
}

/// Vertices of the intersection of a slice of the view frustum and a box: the faces of each body clipped by the planes of
/// the other. `depths`: where the slice begins and ends along the view direction.
pub(super) fn frustum_in_box(view: &View, origin: DVec3, depths: [f64; 2], bounds: Bounds) -> Vec<DVec3> {
    let camera = &view.camera;
    let eye = camera.eye - origin;
    let axes = camera.view_from_world();
    let (right, up, back) = (axes.row(0), axes.row(1), axes.row(2));
    let tan_y = (0.5 * camera.fov_y_deg.to_radians()).tan();
    let tan_x = tan_y * f64::from(view.size[0]) / f64::from(view.size[1]);
    let corner = |i: usize| {
        let sign = |bit: usize| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
        let z = depths[i >> 2 & 1];
        eye + (right * (sign(0) * tan_x) + up * (sign(1) * tan_y) - back) * z
    };
    let frustum: [DVec3; 8] = std::array::from_fn(corner);
    let bodies = [frustum, box_corners(bounds)];
    // corner i has bit 0 for the first axis, bit 1 for the second, bit 2 for the third: these are the faces
    const FACES: [[usize; 4]; 6] = [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]];
    let mut points = Vec::new();
    for (body, other) in [(0, 1), (1, 0)] {
        let middle = bodies[other].iter().sum::<DVec3>() / 8.0;
        for face in FACES {
            let mut polygon: Vec<_> = face.iter().map(|&i| bodies[body][i]).collect();
            for plane in FACES {
                let [a, b, c] = [plane[0], plane[1], plane[2]].map(|i| bodies[other][i]);
                let normal = (b - a).cross(c - a);
                let normal = if normal.dot(middle - a) < 0.0 { -normal } else { normal };
                polygon = clip(&polygon, |p| normal.dot(p - a));
            }
            points.extend(polygon);
        }
    }
    points
}

/// The part of a convex polygon where `distance` is not negative (Sutherland, Hodgman).
fn clip(polygon: &[DVec3], distance: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let mut out = Vec::with_capacity(polygon.len() + 1);
    for (i, &p) in polygon.iter().enumerate() {
        let q = polygon[(i + 1) % polygon.len()];
        let (dp, dq) = (distance(p), distance(q));
        if dp >= 0.0 {
            out.push(p);
        }
        if (dp >= 0.0) != (dq >= 0.0) {
            out.push(p + (q - p) * (dp / (dp - dq)));
        }
    }
    out
}

/// Coordinates across a parallel light, relative to the eye.
pub(super) fn across(points: &[DVec3], eye: DVec3, [x, y, _]: [DVec3; 3]) -> Vec<DVec2> {
    points.iter().map(|p| DVec2::new((*p - eye).dot(x), (*p - eye).dot(y))).collect()
}

/// The rectangle of least area among [`ANGLES`] rotations that holds all points, with a border in texels; none without a
/// point.
pub(super) fn least_area(points: &[DVec2], resolution: f64, border: f64) -> Fit {
    if points.is_empty() {
        return Fit { row_u: [0.0, 0.0, 2.0, 0.0], row_v: [0.0, 0.0, 2.0, 0.0], row_w: UNWARPED, texel: [0.0; 4] };
    }
    let mut best = (f64::INFINITY, Fit::zeroed());
    for a in 0..ANGLES {
        let (sin, cos) = (f64::from(a) * std::f64::consts::FRAC_PI_2 / f64::from(ANGLES)).sin_cos();
        let turned = points.iter().map(|p| DVec2::new(cos * p.x + sin * p.y, cos * p.y - sin * p.x));
        let (low, high) = turned.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        let size = ((high - low) * (resolution / (resolution - 2.0 * border))).max(DVec2::splat(1e-9));
        let low = 0.5 * (low + high) - 0.5 * size;
        if size.x * size.y < best.0 {
            let row =
                |x: f64, y: f64, low: f64, size: f64| [(x / size) as f32, (y / size) as f32, (-low / size) as f32, 0.0];
            let fit = Fit {
                row_u: row(cos, sin, low.x, size.x),
                row_v: row(-sin, cos, low.y, size.y),
                row_w: UNWARPED,
                texel: [(size.x / resolution) as f32, (size.y / resolution) as f32, 0.0, 0.0],
            };
            best = (size.x * size.y, fit);
        }
    }
    best.1
}
