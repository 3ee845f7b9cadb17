//! Scenes made in code, with a view each. Units are metres, y points up.

use crate::bench::{Lcg, view};
use glam::{DVec3, Vec3};
use umbrage::ALPHA_TESTED;
use umbrage::lab::View;
use umbrage::scene::{Attributes, CLUSTER_TRIANGLES, Cluster, Instance, Material, Mesh, Scene, builtin};

const IDENTITY: [[f32; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
const OPAQUE: Material = Material { base_color: [0.8, 0.8, 0.8, 1.0], ..Material::WHITE };

/// A sheet of `n` x `n` cells; `place` maps (0..1, 0..1) to space.
fn sheet(n: u32, place: impl Fn(f64, f64) -> DVec3) -> Vec<([f64; 2], DVec3)> {
    let at = |x: u32, y: u32| {
        let (u, v) = (f64::from(x) / f64::from(n), f64::from(y) / f64::from(n));
        ([u, v], place(u, v))
    };
    let cell = |i: u32| {
        let (x, y) = (i % n, i / n);
        let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
        [a, b, c, a, c, d]
    };
    (0..n * n).flat_map(cell).collect()
}

fn plane(half: f64) -> Vec<([f64; 2], DVec3)> {
    sheet(12, |u, v| DVec3::new((2.0 * u - 1.0) * half, 0.0, (2.0 * v - 1.0) * half))
}

/// Its lower sides are turned inwards.
fn block(low: DVec3, high: DVec3) -> Vec<([f64; 2], DVec3)> {
    let side = |axis: usize, end: f64| {
        sheet(1, move |u, v| {
            let mut t = DVec3::splat(end);
            (t[(axis + 1) % 3], t[(axis + 2) % 3]) = (u, v);
            low + t * (high - low)
        })
    };
    (0..3).flat_map(|axis| [side(axis, 0.0), side(axis, 1.0)]).flatten().collect()
}

fn sphere(centre: DVec3, radius: f64) -> Vec<([f64; 2], DVec3)> {
    sheet(48, |u, v| {
        let (a, b) = (u * std::f64::consts::TAU, v * std::f64::consts::PI);
        centre + radius * DVec3::new(b.sin() * a.cos(), b.cos(), b.sin() * a.sin())
    })
}

/// Collects meshes of one instance each.
struct Builder(Scene);

impl Builder {
    fn new(name: &str) -> Self {
        let (bounds_min, bounds_max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        Self(Scene { name: name.into(), bounds_min, bounds_max, ..Scene::default() })
    }

    fn add(&mut self, material: Material, vertices: &[([f64; 2], DVec3)]) {
        let scene = &mut self.0;
        let first_index = scene.indices.len() as u32;
        let first_cluster = scene.clusters.len() as u32;
        let mesh = scene.meshes.len() as u32;
        for triangle in vertices.chunks(3).filter(|t| (t[1].1 - t[0].1).cross(t[2].1 - t[0].1).length() > 1e-12) {
            for &(uv, p) in triangle {
                scene.indices.push(scene.positions.len() as u32);
                scene.positions.push(p.as_vec3().to_array());
                scene.attributes.push(Attributes { uv: uv.map(|v| v as f32), color: u32::MAX });
                scene.bounds_min = scene.bounds_min.min(p);
                scene.bounds_max = scene.bounds_max.max(p);
            }
        }
        let own: Vec<u32> = scene.indices[first_index as usize..].to_vec();
        for (i, chunk) in own.chunks(3 * CLUSTER_TRIANGLES).enumerate() {
            let corners = || chunk.iter().map(|&i| Vec3::from(scene.positions[i as usize]));
            let (low, high) = (corners().reduce(Vec3::min).unwrap(), corners().reduce(Vec3::max).unwrap());
            let center = 0.5 * (low + high);
            let extent = (high - center).max(center - low).to_array().map(|e| e.next_up().next_up());
            let first_index = first_index + (3 * CLUSTER_TRIANGLES * i) as u32;
            let triangle_count = chunk.len() as u32 / 3;
            scene.clusters.push(Cluster { center: center.to_array(), first_index, extent, triangle_count });
        }
        scene.instances.push(Instance {
            rows: IDENTITY,
            low: [0.0; 4],
            material: mesh,
            mesh,
            revision: 0,
            flags: u32::from(material.alpha_cutoff > 0.0) * ALPHA_TESTED,
        });
        scene.meshes.push(Mesh {
            first_index,
            index_count: own.len() as u32,
            first_cluster,
            cluster_count: scene.clusters.len() as u32 - first_cluster,
            material: mesh,
            first_instance: mesh,
            instance_count: 1,
            casts: true,
            alpha_tested: material.alpha_cutoff > 0.0,
        });
        scene.materials.push(material);
    }

    /// Moves the origin to the middle of the bounds.
    fn finish(mut self) -> Scene {
        let scene = &mut self.0;
        scene.origin = 0.5 * (scene.bounds_min + scene.bounds_max);
        for row in 0..3 {
            scene.instances.iter_mut().for_each(|i| i.rows[row][3] = -scene.origin[row] as f32);
        }
        self.0
    }
}

pub fn street(size: [u32; 2]) -> (Scene, View) {
    (builtin(), view([9.0, 1.7, 9.5], [-2.0, 1.2, -1.5], [-0.5, -0.8, -0.35], size))
}

pub fn low_sun(size: [u32; 2]) -> (Scene, View) {
    (builtin(), view([7.0, 5.0, 9.0], [-2.0, 0.0, -1.0], [-1.0, -0.22, -0.3], size))
}

pub fn sphere_on_plane(size: [u32; 2]) -> (Scene, View) {
    let mut b = Builder::new("sphere");
    b.add(OPAQUE, &plane(6.0));
    b.add(OPAQUE, &sphere(DVec3::new(0.0, 1.3, 0.0), 1.0));
    (b.finish(), view([3.0, 4.0, 6.0], [0.5, 0.4, 0.0], [0.6, -1.0, -0.3], size))
}

/// A block with all sides turned outwards.
fn closed_block(low: DVec3, high: DVec3) -> Vec<([f64; 2], DVec3)> {
    let mut corners = block(low, high);
    let middle = 0.5 * (low + high);
    for triangle in corners.chunks_exact_mut(3) {
        let [a, b, c] = [triangle[0].1, triangle[1].1, triangle[2].1];
        if (b - a).cross(c - a).dot(a - middle) < 0.0 {
            triangle.swap(1, 2);
        }
    }
    corners
}

/// Closed bodies that do not touch: a slab with a sphere and blocks over it.
pub fn closed(size: [u32; 2]) -> (Scene, View) {
    let mut b = Builder::new("closed");
    b.add(OPAQUE, &closed_block(DVec3::new(-6.0, -1.0, -6.0), DVec3::new(6.0, 0.0, 6.0)));
    b.add(OPAQUE, &sphere(DVec3::new(0.0, 1.6, 0.0), 1.0));
    b.add(OPAQUE, &closed_block(DVec3::new(1.5, 0.3, -2.0), DVec3::new(2.5, 1.8, -1.0)));
    b.add(OPAQUE, &closed_block(DVec3::new(-3.0, 0.8, 0.5), DVec3::new(-2.0, 1.6, 2.0)));
    (b.finish(), view([3.0, 4.0, 6.0], [0.0, 0.4, 0.0], [0.6, -1.0, -0.3], size))
}

/// A plane and a horizontal sheet over it that faces up.
pub fn awning(size: [u32; 2]) -> (Scene, View) {
    let mut b = Builder::new("awning");
    b.add(OPAQUE, &plane(6.0));
    b.add(OPAQUE, &sheet(3, |u, v| DVec3::new(3.0 * v - 1.5, 1.5, 3.0 * u - 1.5)));
    (b.finish(), view([3.0, 5.0, 7.0], [0.0, 0.3, 0.0], [0.3, -1.0, -0.4], size))
}

/// A closed room with small blocks around its middle (0, 1.5, 0), close to where the faces of a light there meet.
pub fn swarm(size: [u32; 2]) -> (Scene, View) {
    let mut b = Builder::new("swarm");
    b.add(OPAQUE, &block(DVec3::new(-4.0, 0.0, -4.0), DVec3::new(4.0, 3.0, 4.0)));
    let mut lcg = Lcg(77);
    for i in 0..240 {
        let sign = |lcg: &mut Lcg| if lcg.below(2) == 0 { 1.0 } else { -1.0 };
        let (along, off) = (lcg.between(-1.0, 1.0), 1.0 + lcg.between(-0.06, 0.06));
        let mut v = DVec3::splat(along);
        (v[i % 3], v[(i + 1) % 3]) = (sign(&mut lcg), sign(&mut lcg) * off);
        let low = DVec3::new(0.0, 1.5, 0.0) + v * lcg.between(0.8, 1.3);
        b.add(OPAQUE, &block(low, low + DVec3::splat(lcg.between(0.02, 0.05))));
    }
    (b.finish(), view([3.6, 2.6, 3.5], [-1.0, 0.8, -1.2], [0.3, -1.0, -0.4], size))
}

/// A closed room of few large triangles, seen from inside, with posts and a slab around its middle (0, 1.5, 0).
pub fn room(size: [u32; 2]) -> (Scene, View) {
    let mut b = Builder::new("room");
    b.add(OPAQUE, &block(DVec3::new(-4.0, 0.0, -4.0), DVec3::new(4.0, 3.0, 4.0)));
    for i in 0..10 {
        let angle = f64::from(i) * std::f64::consts::TAU / 10.0 + 0.1;
        let foot = DVec3::new(1.6 * angle.cos(), if i % 2 == 0 { 0.0 } else { 1.8 }, 1.6 * angle.sin());
        b.add(OPAQUE, &block(foot, foot + DVec3::new(0.15, 1.2, 0.15)));
    }
    // long bars beside and below the middle: they pass through the planes of several faces
    b.add(OPAQUE, &block(DVec3::new(-3.0, 1.0, -0.3), DVec3::new(3.0, 1.1, -0.1)));
    b.add(OPAQUE, &block(DVec3::new(-0.4, 1.7, -3.0), DVec3::new(-0.3, 1.8, 3.0)));
    (b.finish(), view([3.6, 2.6, 3.5], [-1.0, 0.8, -1.2], [0.3, -1.0, -0.4], size))
}

/// A floor in the plane y = 0 and a sheet above it whose one edge runs from [`SHEET_EDGE`]'s first point to its second.
pub fn sheet_over_floor(size: [u32; 2]) -> (Scene, View) {
    let mut b = Builder::new("sheet");
    b.add(OPAQUE, &plane(6.0));
    let [from, to] = SHEET_EDGE.map(DVec3::from);
    b.add(OPAQUE, &sheet(8, |u, v| (from + v * (to - from)) - DVec3::X * (12.0 * u)));
    (b.finish(), view([4.0, 3.2, 4.5], [0.4, 0.0, 0.0], [0.25, -1.0, 0.2], size))
}

/// Ends of the sheet's edge.
pub const SHEET_EDGE: [[f64; 3]; 2] = [[-0.9, 1.5, -10.0], [0.7, 1.5, 10.0]];

/// A floor and a sheet above it that covers half of it: the plane's view from above, and the ends of the border between.
pub fn half_plane(size: [u32; 2], angle: f64, offset: f64) -> (Scene, View, [DVec3; 2]) {
    let mut b = Builder::new("half plane");
    b.add(OPAQUE, &plane(4.0));
    let inwards = half_plane_inwards(angle);
    let along = inwards.cross(DVec3::Y);
    let corner = |u: f64, v: f64| DVec3::Y * 6.0 + inwards * (offset + 12.0 * u) + along * (24.0 * v - 12.0);
    b.add(OPAQUE, &sheet(3, corner));
    (b.finish(), view([0.1, 4.0, 1.5], [0.0, 0.0, 0.0], [0.05, -1.0, 0.03], size), [corner(0.0, 0.0), corner(0.0, 1.0)])
}

/// Where its sheet lies from its border.
pub fn half_plane_inwards(angle: f64) -> DVec3 {
    DVec3::new(angle.cos(), 0.0, angle.sin())
}

/// A plane that rises by `slope` along x + z / 2, and nothing else.
pub fn slope(size: [u32; 2], slope: f64) -> (Scene, View) {
    let mut b = Builder::new("slope");
    b.add(
        OPAQUE,
        &sheet(12, |u, v| {
            let (x, z) = (8.0 * u - 4.0, 8.0 * v - 4.0);
            DVec3::new(x, slope * (x + 0.5 * z), z)
        }),
    );
    (b.finish(), view([1.0, 8.0, 7.0], [0.0, 0.0, 0.0], [0.25, -1.0, 0.2], size))
}

pub fn thin_poles(size: [u32; 2]) -> (Scene, View) {
    let mut b = Builder::new("poles");
    b.add(OPAQUE, &plane(6.0));
    for i in 0..48 {
        let foot = DVec3::new(-3.5 + 0.15 * f64::from(i), -0.05, 0.3 * f64::from(i % 3));
        b.add(OPAQUE, &block(foot, foot + DVec3::new(0.03, 1.8, 0.03)));
    }
    (b.finish(), view([1.0, 3.0, 5.0], [0.5, 0.3, 0.0], [0.5, -1.0, -0.8], size))
}

/// Posts over 90 m, seen along their row from eye height.
pub fn long_row(size: [u32; 2]) -> (Scene, View) {
    let mut b = Builder::new("row");
    b.add(OPAQUE, &plane(50.0));
    for i in 0..60 {
        let foot = DVec3::new(f64::from(i % 4) * 1.5 - 2.2, -0.05, 40.0 - 1.5 * f64::from(i));
        b.add(OPAQUE, &block(foot, foot + DVec3::new(0.2, 1.2 + 0.3 * f64::from(i % 3), 0.2)));
    }
    (b.finish(), view([0.3, 1.7, 44.0], [0.0, 1.0, 30.0], [0.7, -1.0, -0.2], size))
}

/// A floor of two triangles over 120 m and a triangle of 60 m above it that ends in the view.
pub fn huge_triangle(size: [u32; 2]) -> (Scene, View) {
    let mut b = Builder::new("triangle");
    b.add(OPAQUE, &sheet(1, |u, v| DVec3::new(120.0 * u - 60.0, 0.0, 120.0 * v - 60.0)));
    let corners = [[-1.5, 2.0, 14.0], [46.0, 2.0, -34.0], [-3.0, 2.0, -45.0]];
    b.add(OPAQUE, &corners.map(|p| ([0.0; 2], p.into())));
    b.add(OPAQUE, &block(DVec3::new(-2.0, -0.05, 12.0), DVec3::new(-1.8, 1.2, 12.2)));
    (b.finish(), view([0.3, 1.7, 17.0], [0.0, 0.9, 10.0], [0.3, -1.0, -0.2], size))
}

/// A sheet of `n` x `n` cells, askew, from over the eye to far before it, above a floor of two triangles.
pub fn canopy(size: [u32; 2], n: u32) -> (Scene, View) {
    let mut b = Builder::new("canopy");
    b.add(OPAQUE, &sheet(1, |u, v| DVec3::new(120.0 * u - 60.0, 0.0, 120.0 * v - 60.0)));
    b.add(
        OPAQUE,
        &sheet(n, |u, v| DVec3::new(-8.0, 3.0, 28.0) + u * DVec3::new(9.0, 0.6, 1.7) - v * DVec3::new(2.3, 0.4, 63.0)),
    );
    (b.finish(), view([0.3, 1.7, 17.0], [-0.4, 0.9, 10.0], [0.3, -1.0, -0.2], size))
}

/// A floor askew with blocks on it, from a seed; unit normal and offset of the floor's plane, world space.
pub fn tilted_floor(size: [u32; 2], seed: u64) -> (Scene, View, DVec3, f64) {
    let mut lcg = Lcg(seed);
    let mut b = Builder::new("tilted floor");
    let [rise, fall] = [(); 2].map(|()| lcg.between(-0.4, 0.4));
    let height = |x: f64, z: f64| 0.7 + rise * x + fall * z;
    b.add(
        OPAQUE,
        &sheet(12, |u, v| {
            let (x, z) = (16.0 * u - 8.0, 16.0 * v - 8.0);
            DVec3::new(x, height(x, z), z)
        }),
    );
    for _ in 0..12 {
        let (x, z) = (lcg.between(-3.0, 3.0), lcg.between(-4.0, 3.0));
        let low = DVec3::new(x, height(x, z) - 1.0, z);
        b.add(
            OPAQUE,
            &block(low, low + DVec3::new(lcg.between(0.3, 1.0), lcg.between(1.2, 2.2), lcg.between(0.3, 1.0))),
        );
    }
    let eye = DVec3::new(1.0, height(1.0, 7.0) + 2.5, 7.0);
    let view = view(eye.to_array(), [0.0, height(0.0, 0.0), 0.0], [0.3, -1.0, -0.4], size);
    let normal = DVec3::new(-rise, 1.0, -fall).normalize();
    (b.finish(), view, normal, 0.7 * normal.y)
}

/// Small plates over 90 m of flat ground under light from above, seen from eye height.
pub fn plates(size: [u32; 2]) -> (Scene, View) {
    let mut b = Builder::new("plates");
    b.add(OPAQUE, &plane(50.0));
    let mut lcg = Lcg(11);
    for i in 0..400 {
        let z = 42.0 - 90.0 * (f64::from(i) / 400.0).powi(2);
        let (x, side) = (lcg.between(-0.6, 0.6) * (46.0 - z), 0.02 * (46.0 - z));
        let (across, along) = (lcg.between(0.5, 1.5) * side, lcg.between(0.5, 1.5) * side);
        let turn = lcg.between(0.0, 1.6);
        let (sin, cos) = turn.sin_cos();
        b.add(
            OPAQUE,
            &sheet(1, |u, v| {
                let (p, q) = ((u - 0.5) * across, (v - 0.5) * along);
                DVec3::new(x + cos * p - sin * q, 3.0, z + sin * p + cos * q)
            }),
        );
    }
    (b.finish(), view([0.3, 1.7, 44.0], [0.0, 1.0, 30.0], [0.0, -1.0, 0.0], size))
}

/// A floor under a larger roof, seen from between them: every sample that faces the light is in shadow.
pub fn under_a_roof(size: [u32; 2]) -> (Scene, View) {
    let mut b = Builder::new("roof");
    b.add(OPAQUE, &plane(20.0));
    b.add(OPAQUE, &block(DVec3::new(-60.0, 3.0, -60.0), DVec3::new(60.0, 3.2, 60.0)));
    (b.finish(), view([0.3, 1.7, 15.0], [0.0, 0.5, 0.0], [0.4, -1.0, -0.2], size))
}

/// Leaves whose outline is a disc in an 8x8 alpha texture.
pub fn leaves(size: [u32; 2]) -> (Scene, View) {
    let mut b = Builder::new("leaves");
    let texel = |i: u32| {
        let d = [i % 8, i / 8].map(|c| (f64::from(c) - 3.5) / 4.0);
        let alpha = (255.0 * (1.35 - (d[0] * d[0] + d[1] * d[1]).sqrt()).clamp(0.0, 1.0)) as u32;
        alpha << 24 | 0x0030_a030
    };
    b.0.texels = (0..64).map(texel).collect();
    b.add(OPAQUE, &plane(6.0));
    let leaf = Material { texel_offset: 0, width: 8, height: 8, wrap: 0b1010, alpha_cutoff: 0.5, ..OPAQUE };
    let mut lcg = Lcg(5);
    let mut quads = Vec::new();
    for _ in 0..60 {
        let centre = DVec3::new(lcg.between(-2.0, 2.0), lcg.between(0.8, 2.2), lcg.between(-1.5, 1.5));
        let right =
            DVec3::new(lcg.between(-1.0, 1.0), lcg.between(-0.3, 0.3), lcg.between(-1.0, 1.0)).normalize() * 0.35;
        let up = right.cross(DVec3::new(0.3, 0.2, 1.0)).normalize() * 0.35;
        quads.extend(sheet(1, |u, v| centre + (2.0 * u - 1.0) * right + (2.0 * v - 1.0) * up));
    }
    b.add(leaf, &quads);
    (b.finish(), view([2.5, 4.0, 6.0], [0.4, 0.5, 0.0], [0.35, -1.0, -0.3], size))
}

/// Blocks and leaves at random over a plane.
pub fn random(size: [u32; 2], seed: u64) -> (Scene, View) {
    let mut lcg = Lcg(seed);
    let mut b = Builder::new("random");
    b.0.texels = (0..16).map(|_| lcg.word()).collect();
    b.add(OPAQUE, &plane(6.0));
    for _ in 0..25 {
        let low = DVec3::new(lcg.between(-5.0, 4.0), lcg.between(-0.1, 2.0), lcg.between(-5.0, 4.0));
        let edges = DVec3::new(lcg.between(0.05, 1.5), lcg.between(0.05, 1.5), lcg.between(0.05, 1.5));
        b.add(OPAQUE, &block(low, low + edges));
    }
    let leaf = Material { texel_offset: 0, width: 4, height: 4, alpha_cutoff: 0.5, ..OPAQUE };
    let tilt = DVec3::new(lcg.between(-0.5, 0.5), 2.5, lcg.between(-0.5, 0.5));
    b.add(leaf, &sheet(2, |u, v| tilt + DVec3::new(4.0 * u - 2.0, u * v, 4.0 * v - 2.0)));
    let sun = [lcg.between(-0.8, 0.8), -1.0, lcg.between(-0.8, 0.8)];
    (b.finish(), view([lcg.between(-4.0, 4.0), 4.5, 7.0], [0.0, 0.5, 0.0], sun, size))
}

/// A ground of 10 km in two triangles and a block of 1 cm on it, seen from 2 cm above.
pub fn huge_ground(size: [u32; 2]) -> (Scene, View) {
    let mut b = Builder::new("huge ground");
    b.add(OPAQUE, &sheet(1, |u, v| DVec3::new(1e4 * v - 5e3, 0.0, 1e4 * u - 5e3)));
    let foot = DVec3::new(1200.0, 0.0, -700.0);
    b.add(OPAQUE, &block(foot, foot + DVec3::new(0.01, 0.012, 0.01)));
    b.add(OPAQUE, &block(DVec3::new(0.0, 0.0, 0.0), DVec3::new(20.0, 30.0, 20.0)));
    let eye = foot + DVec3::new(0.03, 0.02, 0.04);
    (b.finish(), view(eye.to_array(), foot.to_array(), [-0.4, -1.0, 0.3], size))
}

/// Triangles of every size and shape over a plane: points, needles, sheets beyond the plane.
pub fn shards(size: [u32; 2], seed: u64) -> (Scene, View) {
    let mut lcg = Lcg(seed);
    let mut b = Builder::new("shards");
    b.add(OPAQUE, &plane(6.0));
    let direction = |lcg: &mut Lcg| DVec3::from([0; 3].map(|_| lcg.between(-1.0, 1.0))).normalize();
    let mut shards = Vec::new();
    for _ in 0..160 {
        let corner = DVec3::new(lcg.between(-4.0, 4.0), lcg.between(0.3, 2.5), lcg.between(-4.0, 4.0));
        let length = 10f64.powf(lcg.between(-3.0, 0.7));
        let width = length * 10f64.powf(lcg.between(-4.0, 0.0));
        let long = direction(&mut lcg);
        let across = direction(&mut lcg).cross(long).normalize();
        let ends = [corner, corner + length * long, corner + lcg.between(-0.5, 1.5) * length * long + width * across];
        shards.extend(ends.map(|p| ([0.0; 2], p.with_y(p.y.max(0.1)))));
    }
    b.add(OPAQUE, &shards);
    let sun = [lcg.between(-1.5, 1.5), -1.0, lcg.between(-1.5, 1.5)];
    (b.finish(), view([3.0, 5.0, 7.0], [0.0, 0.2, 0.0], sun, size))
}

/// Flat ground in front of an eye 1 m above it that looks along -z; it ends `far` metres away, beyond both sides of the image.
pub fn ground(size: [u32; 2], far: f64, fov_y_deg: f64) -> (Scene, View) {
    let mut b = Builder::new("ground");
    b.add(OPAQUE, &sheet(1, |u, v| DVec3::new((u - 0.5) * far, 0.0, -v * far)));
    let (scene, mut view) = (b.finish(), view([0.0, 1.0, 0.0], [0.0, 1.0, -1.0], [0.0, -1.0, 0.0], size));
    (view.camera.fov_y_deg, view.camera.far) = (fov_y_deg, 2.0 * far);
    (scene, view)
}
