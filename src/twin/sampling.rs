//! The sampling error of a pixel in a fitted map (book, 3.2.1), in double precision and by differences: four points of the
//! receiver's plane beside the pixel's centre are looked up, and the change of place is inverted.

use super::receiver::{decode_normal, xyz};
use crate::gpu::structs::{Fit, SamplingError};
use crate::methods::SamplingInputs;
use glam::{DMat2, DVec2, DVec3};

/// Distance of the points from the pixel's centre, in pixels.
const STEP: f64 = 1e-3;

/// What a pixel's [`crate::methods::SamplingError`] must be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sides {
    /// `s`, `t`, `perspective_s` and `perspective_t`.
    pub sides: [f64; 4],
    /// Part of the map.
    pub part: u32,
    /// Cosine-like margins of what decides the part; near zero rounding may decide otherwise.
    pub margin: f64,
    /// Least cosine between the surface and the rays from eye and light: near zero little is left of the values' digits.
    pub grazing: f64,
}

fn dvec(v: [f32; 4]) -> DVec3 {
    xyz(v).as_dvec3()
}

/// Of a surface at `depth` along the view direction with a packed normal; `None` where there is no surface.
pub fn sides(inputs: &SamplingInputs, pixel: [u32; 2], depth: f32, normal: u32) -> Option<Sides> {
    if depth <= 0.0 {
        return None;
    }
    let SamplingInputs { frame, light, .. } = inputs;
    let centre = DVec2::new(f64::from(pixel[0]) + 0.5, f64::from(pixel[1]) + 0.5);
    let ray = |at: DVec2| dvec(frame.ray_corner) + at.x * dvec(frame.ray_dx) + at.y * dvec(frame.ray_dy);
    let point = ray(centre) * f64::from(depth);
    let normal = decode_normal(normal).as_dvec3().normalize();

    let space = |face: usize, p: DVec3| {
        let f = &light.faces[face];
        DVec3::from([f.x, f.y, f.z].map(|axis| dvec(axis).dot(p) + f64::from(axis[3])))
    };
    let faces = if inputs.position { inputs.fits.len() } else { 1 };
    let mut along: Vec<(f64, usize)> = (0..faces).map(|i| (space(i, point).z, i)).collect();
    along.sort_by(|a, b| b.0.total_cmp(&a.0));
    let (layer, mut margin) = if inputs.position {
        let second = along.get(1).map_or(-1.0, |a| a.0);
        (along[0].1, (along[0].0 - second) / along[0].0.abs())
    } else if let Some(nearest) = inputs.nearest {
        frustum_face(inputs, point, f64::from(depth), f64::from(nearest))
    } else {
        (inputs.splits[1..].iter().filter(|&&split| depth >= split).count(), 1.0)
    };
    let face = if inputs.position { layer } else { 0 };

    // from the light
    let beam = if inputs.position {
        let p = space(0, point);
        (dvec(light.faces[0].x) * p.x + dvec(light.faces[0].y) * p.y + dvec(light.faces[0].z) * p.z).normalize()
    } else {
        dvec(light.faces[0].z)
    };
    let mut reached = -normal.dot(beam);
    if inputs.position {
        let p = space(0, point);
        let cone = p.z / p.length() - f64::from(light.rule[3]);
        reached = reached.min(1.0 - p.length() / f64::from(light.rule[2])).min(cone);
    }
    margin = margin.min(reached.abs());

    let place = |p| place(&inputs.fits[layer], inputs.position, space(face, p));
    if let (Some(warp), Some(at)) = (&inputs.warp, place(point)) {
        // differences say nothing across the end of a cell
        let cells = at * (warp[0].len() - 1) as f64;
        margin = margin.min(1e-2 * (cells - cells.round()).abs().min_element());
    }
    let side = f64::from(inputs.side);
    let in_map = |p| place(p).map(|at| side * warped(inputs.warp.as_ref(), at));
    let at = in_map(point);
    let inside = at.is_some_and(|at| at.min_element() >= 0.0 && at.max_element() < side);
    if reached <= 0.0 || !inside {
        return Some(Sides { sides: [0.0; 4], part: SamplingError::NO_PART, margin, grazing: 1.0 });
    }
    let of_plane = |n: DVec3| {
        let look = |offset: DVec2| {
            let r = ray(centre + offset);
            let p = r * (n.dot(point) / n.dot(r));
            in_map(p).unwrap_or(DVec2::NAN)
        };
        let change = |d: DVec2| (look(STEP * d) - look(-STEP * d)) / (2.0 * STEP);
        let pixels_per_texel = DMat2::from_cols(change(DVec2::X), change(DVec2::Y)).inverse();
        [pixels_per_texel.x_axis.length(), pixels_per_texel.y_axis.length()]
    };
    let eye = ray(centre).normalize();
    let ([s, t], [perspective_s, perspective_t]) = (of_plane(normal), of_plane(-(beam + eye).normalize()));
    let grazing = normal.dot(eye).abs().min(normal.dot(beam).abs()).min((beam + eye).length());
    Some(Sides { sides: [s, t, perspective_s, perspective_t], part: layer as u32, margin, grazing })
}

/// The face of the view frustum through which a line along the light leaves it from a point, on the side that is nearer to the eye:
/// near, left, right, bottom, top; and by how much the next one is farther, over the distances.
fn frustum_face(inputs: &SamplingInputs, point: DVec3, depth: f64, nearest: f64) -> (usize, f64) {
    let frame = &inputs.frame;
    let [width, height] = [frame.size[0], frame.size[1]].map(f64::from);
    let corner =
        |x: f64, y: f64| dvec(frame.ray_corner) + x * width * dvec(frame.ray_dx) + y * height * dvec(frame.ray_dy);
    let forward = corner(0.5, 0.5);
    let light = dvec(inputs.light.faces[0].z);
    let way = if forward.dot(light) > 0.0 { -light } else { light };
    let [top_left, top_right, low_left, low_right] =
        [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(x, y)| corner(x, y));
    let sides = [[top_left, low_left], [top_right, low_right], [low_left, low_right], [top_left, top_right]];
    let near = (0, (depth - nearest) / -forward.dot(way));
    let crossings = sides.iter().zip(1..).map(|([a, b], i)| {
        let normal = a.cross(*b);
        (i, normal.dot(point) / -normal.dot(way))
    });
    // a line that runs along a face, or into it from outside, does not leave by it; a sample lies behind no face but for rounding
    let leaves = |(i, at): &(usize, f64)| {
        let normal = if *i == 0 { forward } else { sides[i - 1][0].cross(sides[i - 1][1]) };
        let inwards = if normal.dot(forward) < 0.0 { -normal } else { normal };
        inwards.dot(way) < -1e-9 && at.is_finite()
    };
    let mut crossings: Vec<_> = [near].into_iter().chain(crossings).filter(leaves).collect();
    crossings.sort_by(|a, b| a.1.total_cmp(&b.1));
    let second = crossings.get(1).map_or(f64::INFINITY, |c| c.1);
    (crossings[0].0, (second - crossings[0].1) / (crossings[0].1 + depth))
}

/// Where a rectilinear warp has a place, both from 0 to 1.
fn warped(warp: Option<&[Vec<f32>; 2]>, at: DVec2) -> DVec2 {
    let along = |ends: &[f32], at: f64| {
        let cells = (ends.len() - 1) as f64;
        let cell = (at * cells).floor().clamp(0.0, cells - 1.0);
        let [low, high] = [0, 1].map(|i| f64::from(ends[cell as usize + i]));
        low + (high - low) * (at * cells - cell)
    };
    warp.map_or(at, |[u, v]| DVec2::new(along(u, at.x), along(v, at.y)))
}

/// Where a point of a layer's light space lies in it, from 0 to 1; `None` behind the light or the warp's line.
fn place(fit: &Fit, position: bool, ls: DVec3) -> Option<DVec2> {
    let w = if position { ls.z } else { 1.0 };
    let row = |row: [f32; 4]| (dvec(row) * DVec3::new(ls.x / w, ls.y / w, 1.0)).element_sum();
    let q = row(fit.row_w);
    let logarithm = f64::from(fit.texel[2]);
    let v = if logarithm == 0.0 { row(fit.row_v) / q } else { logarithm * q.log2() };
    (w > 0.0 && q > 0.0).then(|| DVec2::new(row(fit.row_u) / q, v))
}
