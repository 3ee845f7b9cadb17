//! Pictures of a rectilinear warp: the importance map, the map, and the grid that the warp makes of its cells.

use super::DebugPicture;
use crate::lab::LabError;
use crate::output::Picture;

/// Most pixels along a side.
const SIDE: u32 = 1024;
/// What is not needed, as in the paper.
const UNNEEDED: [u8; 3] = [0, 0, 96];
const LINE: [u8; 3] = [255, 120, 40];
/// Cells between two lines of the grid.
const STEP: usize = 8;
/// Powers of two below the greatest importance that are told apart.
const OCTAVES: f32 = 16.0;

/// `importance`: row by row; `warp`: where cells begin in the map along u and v; `depths`: of the map, `side` a row.
pub(super) fn draw(
    importance: &[f32],
    warp: &[Vec<f32>; 2],
    depths: &[f32],
    side: u32,
) -> Result<Vec<DebugPicture>, LabError> {
    let map = map(depths, side);
    let mut grid = map.clone();
    let size = grid.width;
    let pixel = |at: f32| ((at * size as f32) as u32).min(size - 1);
    warp[0].iter().step_by(STEP).for_each(|u| grid.fill(pixel(*u), 0, 1, size, LINE));
    warp[1].iter().step_by(STEP).for_each(|v| grid.fill(0, pixel(*v), size, 1, LINE));
    let pictures = [("importance", weights(importance)), ("map", map), ("warp", grid)];
    Ok(pictures.map(|(name, p)| DebugPicture { name, width: p.width, height: p.height, rgb: p.rgb }).into())
}

/// The brighter the more important, by powers of two.
fn weights(importance: &[f32]) -> Picture {
    let cells = importance.len().isqrt() as u32;
    let most = importance.iter().copied().fold(f32::MIN_POSITIVE, f32::max);
    let color = |&weight: &f32| {
        let shade = (1.0 + (weight / most).log2() / OCTAVES).clamp(0.0, 1.0);
        if weight > 0.0 { [(40.0 + 215.0 * shade) as u8; 3] } else { UNNEEDED }
    };
    Picture { width: cells, height: cells, rgb: importance.iter().flat_map(color).collect() }
}

/// The nearer the brighter, between the nearest and the farthest caster.
fn map(depths: &[f32], side: u32) -> Picture {
    let drawn = || depths.iter().copied().filter(|d| *d > 0.0);
    let (low, high) = drawn().fold((1.0f32, 0.0f32), |(l, h), d| (l.min(d), h.max(d)));
    let size = side.min(SIDE);
    let mut picture = Picture::filled(size, size, UNNEEDED);
    for (x, y) in (0..size * size).map(|i| (i % size, i / size)) {
        let at = |pixel: u32| (u64::from(pixel) * u64::from(side) / u64::from(size)) as usize;
        let depth = depths[at(y) * side as usize + at(x)];
        if depth > 0.0 {
            let shade = 40.0 + 215.0 * (depth - low) / (high - low).max(1e-9);
            picture.set(x, y, [shade as u8; 3]);
        }
    }
    picture
}
