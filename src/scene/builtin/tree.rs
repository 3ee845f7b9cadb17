//! A tree: branches of rods, leaves of quads with an alpha-tested texture.

use super::shapes::{Shape, rod, sheet};
use glam::{DAffine3, DQuat, DVec3, EulerRot};
use std::f64::consts::TAU;

/// Side of the leaf texture in texels.
pub(super) const LEAF_SIDE: u32 = 64;

/// Wood and leaves, standing at zero.
pub(super) struct Tree {
    pub(super) wood: Shape,
    pub(super) leaves: Shape,
}

/// Numbers between 0 and 1 (Knuth's MMIX generator), the same on every machine.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}

/// A tree about 5 m tall.
pub(super) fn tree() -> Tree {
    let mut random = Random(7);
    let fork = DVec3::new(0.1, 1.9, 0.05);
    let top = DVec3::new(0.2, 3.3, -0.05);
    let mut wood = rod(DVec3::ZERO, fork, [0.17, 0.12], 12);
    wood = wood.with(rod(fork, top, [0.12, 0.06], 10), DAffine3::IDENTITY);
    let mut leaves = Shape::default();
    for branch in 0..14 {
        let turn = f64::from(branch) * TAU * 0.381966;
        let start = fork.lerp(top, f64::from(branch) / 14.0);
        let reach = random.between(0.9, 1.5) * (1.0 - 0.35 * f64::from(branch) / 14.0);
        let end = start + DVec3::new(turn.cos() * reach, random.between(0.5, 1.1), turn.sin() * reach);
        wood = wood.with(rod(start, end, [0.05, 0.015], 6), DAffine3::IDENTITY);
        for twig in 0..4 {
            let from = start.lerp(end, 0.45 + 0.18 * f64::from(twig));
            let spread = DVec3::new(random.between(-0.5, 0.5), random.between(0.0, 0.45), random.between(-0.5, 0.5));
            wood = wood.with(rod(from, from + spread, [0.015, 0.006], 5), DAffine3::IDENTITY);
            leaves = cluster(leaves, from + spread * 0.8, &mut random);
        }
    }
    Tree { wood, leaves }
}

/// Twenty leaves around a twig's end.
fn cluster(mut leaves: Shape, center: DVec3, random: &mut Random) -> Shape {
    for _ in 0..20 {
        let offset = DVec3::new(random.between(-0.3, 0.3), random.between(-0.22, 0.22), random.between(-0.3, 0.3));
        let turn = DQuat::from_euler(
            EulerRot::YXZ,
            random.between(0.0, TAU),
            random.between(-1.1, 0.4),
            random.between(-0.6, 0.6),
        );
        let length = random.between(0.16, 0.26);
        let leaf = sheet(1, 1, |u, v| DVec3::new((u - 0.5) * length * 0.7, 0.0, (v - 0.5) * length));
        let shade = random.between(0.7, 1.0);
        let leaf = leaf.tinted(|_| [shade, shade, 0.8 * shade]);
        leaves = leaves.with(leaf, DAffine3::from_rotation_translation(turn, center + offset));
    }
    leaves
}

/// RGBA8 texels of one leaf: opaque inside a pointed oval with a stem, a paler midrib.
pub(super) fn leaf_texels() -> Vec<u32> {
    (0..LEAF_SIDE * LEAF_SIDE).map(|i| leaf_texel(i % LEAF_SIDE, i / LEAF_SIDE)).collect()
}

fn leaf_texel(x: u32, y: u32) -> u32 {
    let unit = |i: u32| (f64::from(i) + 0.5) / f64::from(LEAF_SIDE) * 2.0 - 1.0;
    let (across, along) = (unit(x).abs(), unit(y));
    let oval = 0.92 * (1.0 - (along * 1.08).powi(2)).max(0.0).powf(0.8) * (1.0 - 0.25 * along);
    let stem = if along > 0.8 { 0.05 } else { 0.0 };
    // the edge ramp spans three texels so that filtering has something to interpolate
    let inside = (oval.max(stem) - across) * f64::from(LEAF_SIDE) / 6.0 + 0.5;
    let alpha = (inside.clamp(0.0, 1.0) * 255.0) as u8;
    let rib = across < 0.05 || ((across * 2.2 + along) * 4.0).rem_euclid(1.0) < 0.1;
    let [r, g, b] = if rib { [150, 178, 98] } else { [104, 146, 62] };
    u32::from_le_bytes([r, g, b, alpha])
}
