//! The kernels of percentage-closer filtering: which texels a lookup reads, and their weights.

use super::key::hash;
use crate::Filter;

/// The points of the disc, in the order of `glsl/shared/kernel.glsl`, whose table this reads.
///
/// # Panics
/// When the shader has no such table.
pub fn disc() -> Vec<[f64; 2]> {
    let source = include_str!("../../glsl/shared/kernel.glsl");
    let table = source.split("vec2[32](").nth(1).and_then(|rest| rest.split(";\n").next()).expect("a table of points");
    let numbers: Vec<f64> =
        table.split(|c: char| !"-.0123456789".contains(c)).filter_map(|word| word.parse().ok()).collect();
    // each pair follows the 2 of `vec2`
    numbers.chunks(3).map(|chunk| [chunk[1], chunk[2]]).collect()
}

/// Texels that a lookup at `texel` (texels from the layer's corner) reads, each with its weight; the weights sum to 1.
/// `pixel`: for the rotation of the disc.
///
/// # Panics
/// For hard shadows, which have no kernel.
pub fn taps(filter: Filter, texel: [f64; 2], pixel: [u32; 2]) -> Vec<([i64; 2], f64)> {
    let square = |n: u32| (0..n * n).map(move |i| [i % n, i / n].map(f64::from));
    let nearest = |place: [f64; 2]| place.map(|c| c.floor() as i64);
    match filter {
        Filter::Hard => panic!("hard shadows have no kernel"),
        Filter::Pcf { taps } => {
            let start = texel.map(|c| c - 0.5 * f64::from(taps - 1));
            let each = 1.0 / f64::from(taps * taps);
            square(taps).map(|[x, y]| (nearest([start[0] + x, start[1] + y]), each)).collect()
        }
        Filter::Poisson { taps } => {
            let angle = f64::from(hash(pixel[0] ^ hash(pixel[1])) >> 8) / 16_777_216.0 * std::f64::consts::TAU;
            let (sin, cos) = angle.sin_cos();
            let radius = 0.5 * f64::from(taps);
            let count = (taps * taps).clamp(16, 32);
            let turned = |[x, y]: [f64; 2]| [x * cos - y * sin, x * sin + y * cos].map(|c| radius * c);
            let place = |[x, y]: [f64; 2]| nearest([texel[0] + x, texel[1] + y]);
            disc()[..count as usize].iter().map(|&p| (place(turned(p)), 1.0 / f64::from(count))).collect()
        }
        Filter::Bilinear { taps } => {
            let start = texel.map(|c| c - 0.5 * f64::from(taps));
            let each = 1.0 / f64::from(taps * taps);
            let bilinear = |[x, y]: [f64; 2]| {
                let place = [start[0] + x, start[1] + y];
                let [left, low] = nearest(place);
                let [f, g] = place.map(|c| c - c.floor());
                [(0, 0, (1.0 - f) * (1.0 - g)), (1, 0, f * (1.0 - g)), (0, 1, (1.0 - f) * g), (1, 1, f * g)]
                    .map(|(dx, dy, weight)| ([left + dx, low + dy], each * weight))
            };
            square(taps).flat_map(bilinear).collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kinds() -> impl Iterator<Item = Filter> {
        (2..=9).flat_map(|taps| [Filter::Pcf { taps }, Filter::Poisson { taps }, Filter::Bilinear { taps }])
    }

    #[test]
    fn weights_sum_to_one_within_the_reach() {
        for filter in kinds() {
            for i in 0..64u32 {
                let texel = [20.0 + 0.37 * f64::from(i), 31.0 + 0.125 * f64::from(i)];
                let taps = taps(filter, texel, [i, 7 * i]);
                let sum: f64 = taps.iter().map(|tap| tap.1).sum();
                assert!((sum - 1.0).abs() < 1e-12 && taps.iter().all(|tap| tap.1 >= 0.0), "{filter:?}: {sum}");
                let own = texel.map(|c| c.floor() as i64);
                let reach = i64::from(filter.reach());
                for (place, _) in taps.iter().filter(|tap| tap.1 > 0.0) {
                    assert!((0..2).all(|k| (place[k] - own[k]).abs() <= reach), "{filter:?}: {place:?} at {texel:?}");
                }
            }
        }
    }

    #[test]
    fn the_disc_fills_its_circle_without_crowding() {
        let disc = disc();
        assert_eq!(disc.len(), 32);
        let distance = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
        for (count, apart) in [(16, 0.35), (25, 0.28), (32, 0.25)] {
            let part = &disc[..count];
            for (i, &p) in part.iter().enumerate() {
                assert!(distance(p, [0.0; 2]) < 1.0, "{p:?}");
                assert!(part[..i].iter().all(|&q| distance(p, q) > apart), "{p:?} of {count}");
            }
            let middle = [0, 1].map(|axis| part.iter().map(|p| p[axis]).sum::<f64>() / count as f64);
            assert!(distance(middle, [0.0; 2]) < 0.05, "{count}: {middle:?}");
        }
    }
}
