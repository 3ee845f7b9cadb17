//! Page keys as 64-bit numbers: the first word of `glsl/shared/key.glsl` above the second.

use super::ROOT_LEVEL;

/// The key of a page; coordinates are those of its level.
pub fn key_of(level: i32, face: u32, page: [u32; 2]) -> u64 {
    let [x, y] = page.map(u64::from);
    ((ROOT_LEVEL + 1 - level) as u64) << 59 | u64::from(face) << 46 | x << 23 | y
}

/// The level of a key; 0 is the finest.
pub fn key_level(key: u64) -> i32 {
    ROOT_LEVEL + 1 - (key >> 59) as i32
}

/// The face of a key's page.
pub fn key_face(key: u64) -> u32 {
    (key >> 46) as u32 & 0x1fff
}

/// The coordinates of a key's page at its level.
pub fn key_page(key: u64) -> [u32; 2] {
    [23, 0].map(|shift| (key >> shift) as u32 & 0x7f_ffff)
}

/// The page `steps` levels coarser that contains the page of `key`; stops at the root level.
pub fn key_ancestor(key: u64, steps: u32) -> u64 {
    let level = key_level(key);
    let coarse = (level + steps as i32).min(ROOT_LEVEL);
    key_of(coarse, key_face(key), key_page(key).map(|c| c >> (coarse - level)))
}

/// Which quarter of its parent a page is.
pub fn key_quadrant(key: u64) -> usize {
    let [x, y] = key_page(key);
    (x & 1 | (y & 1) << 1) as usize
}

/// The form in which keys are sorted: the Morton code in place of the coordinates.
pub fn to_morton(key: u64) -> u64 {
    let [x, y] = key_page(key).map(u64::from);
    let code: u64 = (0..23).map(|bit| (x >> bit & 1) << (2 * bit) | (y >> bit & 1) << (2 * bit + 1)).sum();
    key >> 46 << 46 | code
}

/// The key that [`to_morton`] sorts.
pub fn from_morton(morton: u64) -> u64 {
    let [x, y] = [0, 1].map(|axis| (0..23).map(|bit| (morton >> (2 * bit + axis) & 1) << bit).sum::<u64>());
    morton >> 46 << 46 | x << 23 | y
}

/// The two words of a key.
pub fn words(key: u64) -> [u32; 2] {
    [(key >> 32) as u32, key as u32]
}

/// The key of two words.
pub fn from_words(words: [u32; 2]) -> u64 {
    u64::from(words[0]) << 32 | u64::from(words[1])
}

/// A well-mixed word.
pub fn hash(mut word: u32) -> u32 {
    word = (word ^ word >> 16).wrapping_mul(0x7feb_352d);
    word = (word ^ word >> 15).wrapping_mul(0x846c_a68b);
    word ^ word >> 16
}

/// A well-mixed word of a key.
pub fn key_hash(key: u64) -> u32 {
    let [x, y] = words(key);
    hash(x.wrapping_mul(0x9e37_79b1) ^ y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_hold_level_face_and_page() {
        let pages =
            [(0, 0, [0, 0]), (0, 8191, [8_388_607, 0]), (0, 7, [1, 2]), (5, 1, [511, 3]), (ROOT_LEVEL, 5, [0, 0])];
        for (level, face, page) in pages {
            let key = key_of(level, face, page);
            assert_eq!((key_level(key), key_face(key), key_page(key)), (level, face, page));
            assert!(words(key)[0] != 0 && words(key)[1] != u32::MAX);
            assert_eq!((from_morton(to_morton(key)), from_words(words(key))), (key, key));
        }
        assert_eq!(to_morton(key_of(0, 0, [1, 2])), 24 << 59 | 0b1001);
        assert_eq!(key_ancestor(key_of(3, 4, [13, 6]), 2), key_of(5, 4, [3, 1]));
        assert_eq!(key_ancestor(key_of(22, 0, [1, 1]), 9), key_of(ROOT_LEVEL, 0, [0, 0]));
    }
}
