//! Meshes made from formulas; y points up, units are metres.

use crate::scene::Attributes;
use glam::{DAffine3, DVec2, DVec3};
use std::f64::consts::TAU;

/// Vertices and triangles under construction.
#[derive(Default)]
pub(in crate::scene) struct Shape {
    pub(in crate::scene) positions: Vec<DVec3>,
    pub(in crate::scene) attributes: Vec<Attributes>,
    pub(in crate::scene) triangles: Vec<[u32; 3]>,
}

impl Shape {
    /// Adds another shape, moved.
    pub(super) fn with(mut self, other: Shape, by: DAffine3) -> Self {
        let base = self.positions.len() as u32;
        self.positions.extend(other.positions.iter().map(|p| by.transform_point3(*p)));
        self.attributes.extend(other.attributes);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|i| base + i)));
        self
    }

    /// Adds another shape, shifted.
    pub(super) fn at(self, other: Shape, x: f64, y: f64, z: f64) -> Self {
        self.with(other, DAffine3::from_translation(DVec3::new(x, y, z)))
    }

    /// Gives every vertex a colour, linear 0 to 1, by its position.
    pub(super) fn tinted(mut self, tint: impl Fn(DVec3) -> [f64; 3]) -> Self {
        for (position, attributes) in self.positions.iter().zip(&mut self.attributes) {
            let [r, g, b] = tint(*position).map(|v| (v * 255.0 + 0.5) as u8);
            attributes.color = u32::from_le_bytes([r, g, b, 255]);
        }
        self
    }
}

/// A sheet of `columns` x `rows` cells; `place` maps (0..1, 0..1) to space.
pub(super) fn sheet(columns: u32, rows: u32, place: impl Fn(f64, f64) -> DVec3) -> Shape {
    let mut shape = Shape::default();
    for row in 0..=rows {
        for column in 0..=columns {
            let (u, v) = (f64::from(column) / f64::from(columns), f64::from(row) / f64::from(rows));
            shape.positions.push(place(u, v));
            shape.attributes.push(Attributes { uv: [u as f32, v as f32], color: u32::MAX });
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let a = row * (columns + 1) + column;
            let b = a + columns + 1;
            let cell = [[a, b, b + 1], [a, b + 1, a + 1]];
            let area = |t: &[u32; 3]| {
                let [p, q, r] = t.map(|i| shape.positions[i as usize]);
                (q - p).cross(r - p)
            };
            // cells at poles and tips are single triangles
            let solid = cell.into_iter().filter(|t| area(t) != DVec3::ZERO).collect::<Vec<_>>();
            shape.triangles.extend(solid);
        }
    }
    shape
}

/// A box of the given size standing on the ground.
pub(super) fn block(size: DVec3) -> Shape {
    let corner = |i: u32| {
        let pick = |bit: u32| f64::from(i >> bit & 1);
        DVec3::new(pick(0) - 0.5, pick(1), pick(2) - 0.5) * size
    };
    let sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    let attributes = vec![Attributes { uv: [0.0; 2], color: u32::MAX }; 8];
    Shape { positions: (0..8).map(corner).collect(), attributes, triangles }
}

/// A profile of (radius, height) points turned around the y axis.
pub(super) fn lathe(profile: &[DVec2], segments: u32) -> Shape {
    fluted(profile, segments, |_| 1.0)
}

/// Like [`lathe`], with the radius scaled by a function of the angle.
pub(super) fn fluted(profile: &[DVec2], segments: u32, scale: impl Fn(f64) -> f64) -> Shape {
    let last = profile.len().saturating_sub(1) as f64;
    sheet(segments, profile.len().saturating_sub(1) as u32, |u, v| {
        let point = profile[(v * last).round() as usize];
        // the seam must close exactly
        let angle = if u < 1.0 { u * TAU } else { 0.0 };
        let radius = point.x * scale(angle);
        DVec3::new(radius * angle.sin(), point.y, radius * angle.cos())
    })
}

/// A ball around zero.
pub(super) fn sphere(radius: f64, segments: u32) -> Shape {
    let rings = segments / 2;
    let point = |i: u32| {
        let angle = f64::from(i) / f64::from(rings) * TAU / 2.0;
        DVec2::new(if i == 0 || i == rings { 0.0 } else { radius * angle.sin() }, -radius * angle.cos())
    };
    lathe(&(0..=rings).map(point).collect::<Vec<_>>(), segments)
}

/// A ring around the y axis.
pub(super) fn torus(radius: f64, thickness: f64, segments: u32) -> Shape {
    let sides = segments / 3;
    let point = |i: u32| {
        let angle = if i == sides { 0.0 } else { f64::from(i) / f64::from(sides) * TAU };
        DVec2::new(radius + thickness * angle.sin(), -thickness * angle.cos())
    };
    lathe(&(0..=sides).map(point).collect::<Vec<_>>(), segments)
}

/// A closed tapering rod between two points.
pub(super) fn rod(from: DVec3, to: DVec3, radii: [f64; 2], segments: u32) -> Shape {
    let length = (to - from).length();
    let profile = [[0.0, 0.0], [radii[0], 0.0], [radii[1], length], [0.0, length]].map(DVec2::from);
    let axis = (to - from).try_normalize().unwrap_or(DVec3::Y);
    let turn = glam::DQuat::from_rotation_arc(DVec3::Y, axis);
    Shape::default().with(lathe(&profile, segments), DAffine3::from_rotation_translation(turn, from))
}
