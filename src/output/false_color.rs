//! False colours for levels and identities.

use super::{OutputError, Picture};

pub(crate) const NOTHING: [u8; 3] = [20, 20, 22];

/// Colours of levels 0, 1, 2, ...; they repeat. Neighbours differ in hue and brightness.
pub(crate) const LEVELS: [[u8; 3]; 12] = [
    [230, 60, 50],
    [245, 140, 40],
    [245, 215, 60],
    [150, 210, 60],
    [50, 165, 80],
    [50, 190, 180],
    [70, 160, 240],
    [55, 90, 210],
    [130, 90, 220],
    [200, 100, 220],
    [235, 150, 190],
    [160, 120, 90],
];

/// Colours pixels by level, blending between neighbouring levels, with a legend of the levels that occur. Values that are
/// negative or not finite mean "no level" and stay dark.
///
/// Fails when there is not one value a pixel.
pub fn levels(width: u32, height: u32, values: &[f32]) -> Result<Picture, OutputError> {
    let picture = colored("levels", width, height, values, |&v| {
        if !(v.is_finite() && v >= 0.0) {
            return NOTHING;
        }
        let (low, share) = (v.floor(), v - v.floor());
        let (a, b) = (level_color(low as u32), level_color((low as u32).saturating_add(1)));
        [0, 1, 2].map(|k| (f32::from(a[k]) * (1.0 - share) + f32::from(b[k]) * share).round() as u8)
    })?;
    let mut seen: Vec<u32> = values.iter().filter(|v| v.is_finite() && **v >= 0.0).map(|v| v.round() as u32).collect();
    seen.sort_unstable();
    seen.dedup();
    // 64 bounds the strip; more levels than that are not levels
    let mut legend: Vec<_> = seen.iter().take(64).map(|&l| (format!("level {l}"), level_color(l))).collect();
    legend.push(("none".to_owned(), NOTHING));
    Ok(picture.with_legend(&legend))
}

/// Powers of 2 in the legend of [`factors`], and their colours: below 1 blue, above 1 red.
const FACTORS: [(&str, [u8; 3]); 7] = [
    ("1/8 or less", [40, 50, 140]),
    ("1/4", [60, 110, 200]),
    ("1/2", [120, 180, 220]),
    ("1", [225, 225, 215]),
    ("2", [250, 190, 90]),
    ("4", [230, 90, 50]),
    ("8 or more", [140, 20, 40]),
];

/// Colours pixels by a factor on a logarithmic scale from 1/8 to 8, with a legend that ends with the range that occurs. Values
/// that are negative or not a number mean "nothing" and stay dark.
///
/// Fails when there is not one value a pixel.
pub fn factors(width: u32, height: u32, values: &[f32]) -> Result<Picture, OutputError> {
    let last = FACTORS.len() - 1;
    let picture = colored("factors", width, height, values, |&v| {
        if v.is_nan() || v < 0.0 {
            return NOTHING;
        }
        let at = (v.log2() + 3.0).clamp(0.0, last as f32);
        let (low, share) = (at as usize, at.fract());
        let (a, b) = (FACTORS[low].1, FACTORS[(low + 1).min(last)].1);
        [0, 1, 2].map(|k| (f32::from(a[k]) * (1.0 - share) + f32::from(b[k]) * share).round() as u8)
    })?;
    let some = || values.iter().copied().filter(|v| *v >= 0.0);
    let range = match some().next() {
        Some(first) => {
            let (least, most) = some().fold((first, first), |(l, m), v| (l.min(v), m.max(v)));
            format!("nothing; here {least:.2e} to {most:.2e}")
        }
        None => "nothing".to_owned(),
    };
    let legend: Vec<_> =
        FACTORS.map(|(name, color)| (name.to_owned(), color)).into_iter().chain([(range, NOTHING)]).collect();
    Ok(picture.with_legend(&legend))
}

/// Colours pixels by identity: equal numbers get equal colours, close ones unrelated colours. `u32::MAX` means "nothing"
/// and stays dark.
///
/// Fails when there is not one value a pixel.
pub fn ids(width: u32, height: u32, values: &[u32]) -> Result<Picture, OutputError> {
    colored("ids", width, height, values, |&id| {
        if id == u32::MAX {
            return NOTHING;
        }
        let h = hash(id);
        // 64..255 keeps every colour apart from NOTHING
        [0, 8, 16].map(|shift| 64 + ((h >> shift & 255) * 191 / 255) as u8)
    })
}

fn colored<T>(
    name: &str,
    width: u32,
    height: u32,
    values: &[T],
    color: impl Fn(&T) -> [u8; 3],
) -> Result<Picture, OutputError> {
    if values.is_empty() || values.len() != width as usize * height as usize {
        return Err(OutputError::size(name, values.len(), width, height));
    }
    Ok(Picture { width, height, rgb: values.iter().flat_map(color).collect() })
}

fn level_color(level: u32) -> [u8; 3] {
    LEVELS[level as usize % LEVELS.len()]
}

/// The finaliser of MurmurHash3: one-to-one, every input bit reaches every output bit.
fn hash(mut x: u32) -> u32 {
    x = (x ^ (x >> 16)).wrapping_mul(0x85eb_ca6b);
    x = (x ^ (x >> 13)).wrapping_mul(0xc2b2_ae35);
    x ^ (x >> 16)
}
