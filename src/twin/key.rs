//! Page keys: bits 28-31 hold `ROOT_LEVEL + 1 - level`, bits 0-27 the Morton code of the page at its level.

use super::ROOT_LEVEL;

/// The key of a page; coordinates are those of its level.
pub fn key_of(level: i32, page: [u32; 2]) -> u32 {
    let morton = (0..14).map(|bit| (page[0] >> bit & 1) << (2 * bit) | (page[1] >> bit & 1) << (2 * bit + 1));
    ((ROOT_LEVEL + 1 - level) as u32) << 28 | morton.sum::<u32>()
}

/// The level of a key; 0 is the finest.
pub fn key_level(key: u32) -> i32 {
    ROOT_LEVEL + 1 - (key >> 28) as i32
}

/// The coordinates of a key's page at its level.
pub fn key_page(key: u32) -> [u32; 2] {
    [0, 1].map(|axis| (0..14).map(|bit| (key >> (2 * bit + axis) & 1) << bit).sum())
}

/// The page `steps` levels coarser that contains the page of `key`; stops at the root level.
pub fn key_ancestor(key: u32, steps: u32) -> u32 {
    let level = key_level(key);
    let coarse = (level + steps as i32).min(ROOT_LEVEL);
    key_of(coarse, key_page(key).map(|c| c >> (coarse - level)))
}

/// A well-mixed word.
pub fn hash(mut word: u32) -> u32 {
    word = (word ^ word >> 16).wrapping_mul(0x7feb_352d);
    word = (word ^ word >> 15).wrapping_mul(0x846c_a68b);
    word ^ word >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_hold_level_and_page() {
        for (level, page) in [(0, [0, 0]), (0, [16383, 16383]), (0, [1, 2]), (5, [511, 3]), (ROOT_LEVEL, [1, 1])] {
            let key = key_of(level, page);
            assert_eq!((key_level(key), key_page(key)), (level, page));
            assert_ne!(key, 0);
        }
        assert_eq!(key_of(0, [1, 2]), 14 << 28 | 0b1001);
        assert_eq!(key_ancestor(key_of(3, [13, 6]), 2), key_of(5, [3, 1]));
        assert_eq!(key_ancestor(key_of(12, [3, 1]), 9), key_of(ROOT_LEVEL, [1, 0]));
    }
}
