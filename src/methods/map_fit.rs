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

/// Middle and radius of a sphere around a slice of a view frustum; both as distances along the view direction. `tan`: of half the
/// angles that the frustum opens.
pub(super) fn slice_sphere([near, far]: [f64; 2], tan: DVec2) -> [f64; 2] {
    let wide = tan.length_squared();
    let middle = (0.5 * (near + far) * (1.0 + wide)).min(far);
    let radius = ((far - middle).powi(2) + far * far * wide).max((middle - near).powi(2) + near * near * wide).sqrt();
    [middle, radius]
}

/// A square of whole texels that holds a circle: its corner lies on a grid that stands in the world, so that texels stay where
/// they are while the eye moves (Valient 2008; book, 4.1). `middle` and `eye`: across the light, from the scene's origin;
/// `border`: texels around the circle.
pub(super) fn snapped(middle: DVec2, radius: f64, eye: DVec2, resolution: f64, border: f64) -> Fit {
    // one texel more, by which the corner moves
    let texel = 2.0 * radius / (resolution - 2.0 * border - 1.0);
    let size = texel * resolution;
    let low = ((middle - DVec2::splat(radius)) / texel - border).floor() * texel - eye;
    let row = |axis: DVec2, low: f64| [(axis.x / size) as f32, (axis.y / size) as f32, (-low / size) as f32, 0.0];
    Fit {
        row_u: row(DVec2::X, low.x),
        row_v: row(DVec2::Y, low.y),
        row_w: UNWARPED,
        texel: [texel as f32, texel as f32, 0.0, 0.0],
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Corners of a slice lie in its sphere, and one of them on it.
    #[test]
    fn spheres_hold_their_slices() {
        for tan in [DVec2::new(0.3, 0.2), DVec2::new(1.0, 0.6), DVec2::new(2.0, 1.5)] {
            for (near, far) in [(0.1, 1.0), (1.0, 1.5), (10.0, 400.0)] {
                let [middle, radius] = slice_sphere([near, far], tan);
                let reach = [near, far].map(|d| ((d - middle).powi(2) + (d * tan).length_squared()).sqrt());
                let farthest = reach[0].max(reach[1]);
                assert!((farthest - radius).abs() < 1e-9 * radius, "{tan}, {near} to {far}: {reach:?}, {radius}");
            }
        }
    }

    /// Whatever the eye does, texels have one size and corners differ by whole texels; the circle is inside.
    #[test]
    fn snapped_texels_stay_in_the_world() {
        let (radius, resolution, border) = (7.3, 512.0, 1.0);
        let fit = |eye: DVec2| snapped(eye * 1.1 + DVec2::new(3.0, -2.0), radius, eye, resolution, border);
        let first = fit(DVec2::ZERO);
        let texel = 2.0 * radius / (resolution - 2.0 * border - 1.0);
        for i in 0..200 {
            let eye = DVec2::new(0.0137 * f64::from(i), -0.0091 * f64::from(i));
            let (now, middle) = (fit(eye), eye * 1.1 + DVec2::new(3.0, -2.0));
            assert_eq!(now.texel, first.texel);
            for (row, e, m) in [(now.row_u, eye.x, middle.x), (now.row_v, eye.y, middle.y)] {
                let low = -f64::from(row[2]) * texel * resolution + e;
                let steps = low / texel;
                assert!((steps - steps.round()).abs() < 1e-2, "eye {eye}: {steps} texels");
                assert!(low <= m - radius - 0.9 * border * texel, "eye {eye}: begins at {low}");
                assert!(low + texel * resolution >= m + radius + 0.9 * border * texel, "eye {eye}");
            }
        }
    }
}
