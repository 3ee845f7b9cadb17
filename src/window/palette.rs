//! The colours of the window's shaders, in the order of `glsl/window/palette.glsl`.

use crate::output::false_color::{LEVELS, NOTHING};
use crate::output::shade::{GROUND_AMBIENT, SKY_AMBIENT, SKY_GROUND, SKY_HORIZON, SKY_ZENITH, SUN};
use glam::Vec3;

/// What the colours of a page's state mean.
pub(super) const STATES: [(&str, [u8; 3]); 3] = [
    ("from the cache", [60, 170, 80]),
    ("drawn in this frame", [225, 60, 50]),
    ("coarser than a texel a pixel", [235, 205, 60]),
];

/// Linear light of the shaded picture, then sRGB colours.
pub(super) fn colors() -> Vec<[f32; 4]> {
    let linear = [SUN, SKY_AMBIENT, GROUND_AMBIENT, SKY_ZENITH, SKY_HORIZON, SKY_GROUND];
    let bytes = std::iter::once(NOTHING).chain(STATES.map(|(_, color)| color)).chain(LEVELS);
    let encoded = bytes.map(|color| Vec3::from(color.map(|c| f32::from(c) / 255.0)));
    linear.into_iter().chain(encoded).map(|c| c.extend(1.0).to_array()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The names of the shader's constants count up in the same order.
    #[test]
    fn the_order_is_the_shader_s() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/glsl/window/palette.glsl");
        let text = std::fs::read_to_string(path).unwrap();
        let constant = |name: &str| -> usize {
            let line = text.lines().find(|line| line.starts_with(&format!("const uint {name} = "))).unwrap();
            line.rsplit(' ').next().unwrap().trim_end_matches("u;").parse().unwrap()
        };
        let names = ["SUN", "SKY_AMBIENT", "GROUND_AMBIENT", "SKY_ZENITH", "SKY_HORIZON", "SKY_GROUND", "NOTHING"];
        let states = ["STATE_CACHED", "STATE_DRAWN", "STATE_COARSER", "LEVELS_FIRST"];
        for (place, name) in names.iter().chain(&states).enumerate() {
            assert_eq!(constant(name), place, "{name}");
        }
        assert_eq!(constant("LEVEL_COLORS"), LEVELS.len());
        assert_eq!(colors().len(), constant("LEVELS_FIRST") + LEVELS.len());
        assert_eq!(colors()[constant("STATE_DRAWN")][0], 225.0 / 255.0);
    }
}
