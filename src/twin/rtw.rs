//! The warp of a map's axis from importance (Rosen 2012, 4.2).

/// The greatest importance as a whole number.
const UNIT: f32 = 1_048_576.0;

/// The warp of one axis.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Axis {
    /// Where cells begin in the map, and the last ends.
    pub warp: Vec<f32>,
    /// Centre and width of each of the map's texels without the warp.
    pub centres: Vec<[f32; 2]>,
}

/// The greatest importance of each column and of each row; `importance`: `cells` rows.
pub fn collapse(importance: &[f32], cells: usize) -> [Vec<f32>; 2] {
    let most = |values: &mut dyn Iterator<Item = f32>| values.fold(0.0, f32::max);
    let column = |u: usize| most(&mut importance.iter().skip(u).step_by(cells).copied());
    let row = |v: usize| most(&mut importance[v * cells..][..cells].iter().copied());
    [(0..cells).map(column).collect(), (0..cells).map(row).collect()]
}

/// Gaussian with a standard deviation of `sigma` cells over those that there are.
pub fn blur(raw: &[f32], sigma: f32) -> Vec<f32> {
    if sigma == 0.0 {
        return raw.to_vec();
    }
    let reach = (3.0 * sigma).ceil() as isize;
    let blurred = |cell: usize| {
        let (mut sum, mut weights) = (0.0, 0.0);
        for d in -reach..=reach {
            if let Some(value) = cell.checked_add_signed(d).and_then(|at| raw.get(at)) {
                let weight = ((d * d) as f32 * (-0.5 / (sigma * sigma))).exp();
                sum += weight * value;
                weights += weight;
            }
        }
        sum / weights
    };
    (0..raw.len()).map(blurred).collect()
}

/// Importance before each cell and at the end, in whole numbers.
fn sums(importance: &[f32]) -> Vec<u32> {
    let greatest = importance.iter().copied().fold(0.0, f32::max);
    let whole = |v: f32| match v {
        _ if greatest == 0.0 => 1,
        v if v > 0.0 => ((v * (UNIT / greatest) + 0.5) as u32).max(1),
        _ => 0,
    };
    let mut sum = 0;
    let before = importance.iter().map(|v| {
        sum += whole(*v);
        sum
    });
    std::iter::once(0).chain(before).collect()
}

/// The warp that gives each cell its share of importance, for a map of `side` texels.
pub fn axis(collapsed: &[f32], sigma: f32, side: u32) -> Axis {
    let sums = sums(&blur(collapsed, sigma));
    let (cells, total) = (collapsed.len(), sums[collapsed.len()] as f32);
    let unwarped = |at: f32| {
        let sought = at * total;
        let low = sums[..cells].iter().rposition(|sum| *sum as f32 <= sought).unwrap_or(0);
        let (begin, end) = (sums[low] as f32, sums[low + 1] as f32);
        (low as f32 + ((sought - begin) / (end - begin).max(1.0)).clamp(0.0, 1.0)) / cells as f32
    };
    let texel = |i: u32| {
        let at = |offset: f32| unwarped((i as f32 + offset) / side as f32);
        [at(0.5), unwarped((i + 1) as f32 / side as f32) - at(0.0)]
    };
    Axis { warp: sums.iter().map(|sum| *sum as f32 / total).collect(), centres: (0..side).map(texel).collect() }
}

/// Where the map has a coordinate from 0 to 1.
pub fn warped(warp: &[f32], at: f32) -> f32 {
    let cells = (warp.len() - 1) as f32;
    let cell = (at * cells).floor().min(cells - 1.0);
    let (low, high) = (warp[cell as usize], warp[cell as usize + 1]);
    (low + (high - low) * (at * cells - cell)).clamp(low, high)
}
