//! A scene of our own, made by code: a small temple, a tree, a fence and round bodies on a meadow of 24 x 24 m.

mod knot;
mod shapes;
mod tree;

pub(super) use knot::knot;

use super::assemble::{Part, Surroundings, assemble};
use super::materials::plain;
use super::{Material, Scene};
use glam::{DAffine3, DVec2, DVec3};
use shapes::{Shape, block, fluted, lathe, rod, sheet, sphere, torus};
use std::f64::consts::{PI, TAU};

/// Height of the temple's floor and of its columns. Pieces sink into each other by [`JOINT`]: faces that only touch
/// leak light.
const FLOOR: f64 = 0.54;
const COLUMN: f64 = 3.2;
const JOINT: f64 = 0.02;
/// Where the temple stands, and half the distance between its corner columns.
const TEMPLE: DVec3 = DVec3::new(-3.5, 0.0, -3.0);
const HALF: DVec2 = DVec2::new(3.6, 2.4);

/// Collects parts and their materials.
#[derive(Default)]
struct Builder {
    parts: Vec<Part>,
    materials: Vec<Material>,
}

impl Builder {
    /// Places a shape once for each instance in one colour, linear RGB.
    fn add(&mut self, shape: Shape, color: [f32; 3], instances: Vec<DAffine3>) {
        let [r, g, b] = color;
        self.add_with(shape, plain([r, g, b, 1.0]), false, instances);
    }

    fn add_with(&mut self, shape: Shape, material: Material, alpha_tested: bool, instances: Vec<DAffine3>) {
        let number = self.materials.len() as u32;
        self.materials.push(material);
        self.parts.push(Part {
            positions: shape.positions,
            attributes: shape.attributes,
            triangles: shape.triangles,
            material: number,
            casts: true,
            alpha_tested,
            instances,
            group: number as usize,
            moves: None,
        });
    }
}

pub(super) fn scene() -> Scene {
    let mut builder = Builder::default();
    builder.add(ground(), [1.0, 1.0, 1.0], vec![DAffine3::IDENTITY]);
    temple(&mut builder);
    fence(&mut builder);
    bodies(&mut builder);
    let texels = plant(&mut builder);
    let Builder { parts, materials } = builder;
    // the parts are fixed, so assembly cannot fail; the tests load this scene
    assemble(parts, Surroundings { name: "builtin".to_string(), materials, texels, warnings: Vec::new() })
        .unwrap_or_default()
}

fn at(x: f64, y: f64, z: f64) -> DAffine3 {
    DAffine3::from_translation(DVec3::new(x, y, z))
}

/// Height of the meadow; flat where things stand.
fn height(x: f64, z: f64) -> f64 {
    let hills = 0.35 * (0.55 * x + 1.0).sin() * (0.48 * z).cos() + 0.05 * (2.3 * x).sin() * (2.9 * z + 0.7).sin();
    let away = (x.abs().max(z.abs()) - 7.5) / 4.0;
    hills * away.clamp(0.0, 1.0) + 0.015 * (3.1 * x + 0.4).sin() * (2.7 * z).cos() - 0.02
}

fn ground() -> Shape {
    let place = |u: f64, v: f64| {
        let (x, z) = (24.0 * u - 12.0, 24.0 * v - 12.0);
        DVec3::new(x, height(x, z), z)
    };
    let meadow = sheet(72, 72, place);
    meadow.tinted(|p| {
        let patch = 0.5 + 0.25 * (0.9 * p.x + 0.6 * p.z).sin() + 0.25 * (1.3 * p.z - 0.7 * p.x + 1.0).cos();
        let dry = patch.clamp(0.0, 1.0) * 0.7;
        [0.20 + 0.16 * dry, 0.25 + 0.07 * dry, 0.12 + 0.04 * dry]
    })
}

fn temple(builder: &mut Builder) {
    let stone = [0.60, 0.55, 0.47];
    let origin = vec![DAffine3::from_translation(TEMPLE)];
    let mut base = Shape::default();
    for step in 0..3 {
        let inset = 0.34 * f64::from(step);
        let size = DVec3::new(2.0 * HALF.x + 2.4 - 2.0 * inset, FLOOR / 3.0 + 0.2, 2.0 * HALF.y + 2.4 - 2.0 * inset);
        base = base.at(block(size), 0.0, f64::from(step) * FLOOR / 3.0 - 0.2, 0.0);
    }
    builder.add(base, [0.52, 0.49, 0.44], origin.clone());
    builder.add(column(), stone, column_places());
    let beam = FLOOR + COLUMN - 2.0 * JOINT;
    let (x, z) = (HALF.x, HALF.y);
    let mut lintel = Shape::default();
    for side in [-1.0, 1.0] {
        lintel = lintel.at(block(DVec3::new(2.0 * x + 0.7, 0.42, 0.56)), 0.0, beam, side * z);
        lintel = lintel.at(block(DVec3::new(0.56, 0.42, 2.0 * z - 0.5)), side * x, beam, 0.0);
    }
    for rafter in -3..=3 {
        lintel = lintel.at(block(DVec3::new(0.16, 0.2, 2.0 * z)), 1.02 * f64::from(rafter), beam + 0.22 - JOINT, 0.0);
    }
    builder.add(lintel, stone, origin.clone());
    builder.add(roof(beam + 0.42 - JOINT), [0.42, 0.20, 0.14], origin.clone());
    let pedestal = Shape::default().at(block(DVec3::new(0.8, 0.7, 0.8)), 0.0, FLOOR - JOINT, 0.0);
    builder.add(pedestal, [0.45, 0.45, 0.47], origin.clone());
    builder.add(Shape::default().at(vase(), 0.0, FLOOR + 0.7 - 2.0 * JOINT, 0.0), [0.16, 0.27, 0.36], origin);
}

/// Ten columns around the floor.
fn column_places() -> Vec<DAffine3> {
    let mut places = Vec::new();
    for side in [-1.0, 1.0] {
        for i in 0..4 {
            places.push(DVec3::new(HALF.x * (f64::from(i) / 1.5 - 1.0), FLOOR - JOINT, side * HALF.y));
        }
        places.push(DVec3::new(side * HALF.x, FLOOR - JOINT, 0.0));
    }
    places.into_iter().map(|p| DAffine3::from_translation(TEMPLE + p)).collect()
}

/// A Doric column: sixteen flutes, a slight swell, a round capital under a square plate.
fn column() -> Shape {
    let shaft_top = COLUMN - 0.34;
    let shaft = |i: i32| {
        let t = f64::from(i) / 10.0;
        DVec2::new(0.27 - 0.055 * t + 0.02 * (PI * t).sin(), 0.11 + (shaft_top - 0.11) * t)
    };
    let profile: Vec<DVec2> = (0..=10).map(shaft).collect();
    let body = fluted(&profile, 64, |angle| 1.0 - 0.07 * (8.0 * angle).sin().abs().powi(2));
    let ring = |points: &[[f64; 2]]| lathe(&points.iter().map(|p| DVec2::from(*p)).collect::<Vec<_>>(), 32);
    let foot = ring(&[[0.0, 0.0], [0.34, 0.0], [0.36, 0.06], [0.33, 0.12], [0.0, 0.12]]);
    let top = shaft_top - JOINT / 2.0;
    let head = ring(&[[0.2, top], [0.23, top + 0.05], [0.33, top + 0.15], [0.34, top + 0.2], [0.0, top + 0.2]]);
    let plate = block(DVec3::new(0.74, 0.16, 0.74));
    body.at(foot, 0.0, 0.0, 0.0).at(head, 0.0, 0.0, 0.0).at(plate, 0.0, COLUMN - 0.16 - JOINT / 2.0, 0.0)
}

/// A gabled roof with its underside at `y`.
fn roof(y: f64) -> Shape {
    let (x, z) = (HALF.x + 0.6, HALF.y + 0.6);
    let slab = block(DVec3::new(2.0 * x, 0.12, 2.0 * z));
    let gable = |end: f64| {
        sheet(1, 2, move |u, v| {
            let across = (v * 2.0 - 1.0) * z;
            DVec3::new(end * (x - 0.15), if v == 0.5 { 0.95 * u } else { 0.0 }, across)
        })
    };
    let slope = |side: f64| {
        sheet(24, 1, move |u, v| {
            // round tiles run down the slope
            let wave = 0.03 * (u * 24.0 * PI / 2.0).sin().powi(2);
            DVec3::new((2.0 * u - 1.0) * x, 1.0 * (1.0 - v) + wave, side * v * (z + 0.08))
        })
    };
    let mut shape = Shape::default().at(slab, 0.0, y, 0.0);
    for side in [-1.0, 1.0] {
        shape = shape.at(gable(side), 0.0, y + 0.12 - JOINT, 0.0).at(slope(side), 0.0, y + 0.12 - JOINT, 0.0);
    }
    shape
}

fn vase() -> Shape {
    let point = |i: i32| {
        let t = f64::from(i) / 40.0;
        let belly = 0.13 + 0.25 * (PI * t.powf(0.8)).sin().powi(2) + 0.07 * (t - 0.82).max(0.0) * 6.0;
        DVec2::new(belly, 1.15 * t)
    };
    let mut profile = vec![DVec2::ZERO];
    profile.extend((0..=40).map(point));
    // the inside is seen from above
    profile.extend([[0.17, 1.12], [0.12, 0.95], [0.0, 0.9]].map(DVec2::from));
    lathe(&profile, 40)
}

/// Posts of 7 cm, rails of 2.4 cm and bars of 1.4 cm along the meadow's front right.
fn fence(builder: &mut Builder) {
    let (left, right, z) = (1.2, 9.2, 6.2);
    let iron = [0.07, 0.08, 0.09];
    let bar = rod(DVec3::new(0.0, 0.05, 0.0), DVec3::new(0.0, 1.16, 0.0), [0.007, 0.007], 6);
    let spike = lathe(&[[0.0, 0.0], [0.016, 0.03], [0.0, 0.12]].map(DVec2::from), 6);
    let bars = (0..64).map(|i| at(left + 0.0625 + 0.125 * f64::from(i), 0.0, z)).collect();
    builder.add(bar.at(spike, 0.0, 1.15, 0.0), iron, bars);
    let post = block(DVec3::new(0.07, 1.4, 0.07)).at(sphere(0.055, 16), 0.0, 1.43, 0.0);
    builder.add(post, [0.12, 0.12, 0.12], (0..5).map(|i| at(left + 2.0 * f64::from(i), -0.1, z)).collect());
    let rail = rod(DVec3::new(left, 0.0, 0.0), DVec3::new(right, 0.0, 0.0), [0.012, 0.012], 8);
    builder.add(rail, iron, vec![at(0.0, 0.16, z), at(0.0, 1.06, z)]);
}

fn bodies(builder: &mut Builder) {
    builder.add(sphere(0.75, 72), [0.62, 0.30, 0.20], vec![at(3.4, 0.74, 2.8)]);
    let lean = DAffine3::from_rotation_x(1.15);
    builder.add(torus(0.75, 0.2, 84), [0.16, 0.34, 0.35], vec![at(5.9, 0.83, 3.3) * lean]);
    let crate_turn = DAffine3::from_rotation_y(0.5);
    let crates =
        vec![at(6.6, -0.02, -1.2) * crate_turn, at(6.7, 0.88, -1.15) * DAffine3::from_rotation_y(-0.3) * scale(0.6)];
    builder.add(crate_box(), [0.46, 0.32, 0.18], crates);
    let mut stairs = Shape::default();
    for step in 0..7 {
        let rise = 0.2 * f64::from(step + 1);
        stairs = stairs.at(block(DVec3::new(0.3, rise + 0.1, 1.6)), 0.3 * f64::from(step), -0.1, 0.0);
    }
    stairs = stairs.at(block(DVec3::new(1.2, 1.5, 1.6)), 2.55, -0.1, 0.0);
    builder.add(stairs, [0.50, 0.46, 0.42], vec![at(5.6, 0.0, -6.0)]);
    builder.add(lamp(), [0.10, 0.11, 0.12], vec![at(0.6, 0.0, 4.4)]);
    let small = [(1.7, 3.9, 0.22), (2.2, 4.5, 0.16), (-6.4, 4.6, 0.34), (-5.6, 5.1, 0.2), (9.0, 1.2, 0.3)];
    let stones = small
        .map(|(x, z, r)| at(x, height(x, z) + 0.5 * r, z) * DAffine3::from_scale(DVec3::new(r, 0.7 * r, 0.85 * r)));
    builder.add(sphere(1.0, 20), [0.34, 0.33, 0.32], stones.to_vec());
}

fn scale(by: f64) -> DAffine3 {
    DAffine3::from_scale(DVec3::splat(by))
}

/// A crate: a box with battens along its edges.
fn crate_box() -> Shape {
    let mut shape = Shape::default().at(block(DVec3::splat(0.84)), 0.0, 0.03, 0.0);
    for (a, b) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
        shape = shape.at(block(DVec3::new(0.08, 0.9, 0.08)), 0.41 * a, 0.0, 0.41 * b);
        let y = 0.41 + 0.41 * a;
        shape = shape.at(block(DVec3::new(0.9, 0.08, 0.08)), 0.0, y, 0.41 * b);
        shape = shape.at(block(DVec3::new(0.08, 0.08, 0.9)), 0.41 * b, y, 0.0);
    }
    shape
}

/// A street lamp: a thin pole with a hoop.
fn lamp() -> Shape {
    let pole = rod(DVec3::ZERO, DVec3::new(0.0, 3.0, 0.0), [0.045, 0.03], 12);
    let hoop = DAffine3::from_translation(DVec3::new(0.0, 3.28, 0.0)) * DAffine3::from_rotation_x(TAU / 4.0);
    pole.with(torus(0.28, 0.018, 36), hoop).at(sphere(0.14, 24), 0.0, 3.26, 0.0)
}

/// Two trees that share their meshes; returns the leaf texture.
fn plant(builder: &mut Builder) -> Vec<u32> {
    let tree::Tree { wood, leaves } = tree::tree();
    let places = vec![
        at(2.6, -0.05, -2.2),
        at(-8.8, height(-8.8, 4.0) - 0.05, 4.0) * DAffine3::from_rotation_y(2.0) * scale(0.8),
    ];
    builder.add(wood, [0.20, 0.13, 0.08], places.clone());
    let side = tree::LEAF_SIDE;
    let leaf =
        Material { texel_offset: 0, width: side, height: side, wrap: 2 | 2 << 2, alpha_cutoff: 0.5, ..plain([1.0; 4]) };
    builder.add_with(leaves, leaf, true, places);
    tree::leaf_texels()
}
