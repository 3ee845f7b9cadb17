//! Each key once with the sum of its values.

use super::SHIFTS;
use super::key::{from_morton, key_ancestor, to_morton};
use std::collections::BTreeMap;

/// What is left of a sorted list.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Compacted {
    /// Distinct keys in order, each with the sum of its values.
    pub entries: Vec<(u64, u32)>,
    /// Runs of equal keys, as they are and with all keys coarsened by each of [`SHIFTS`]. A run is what neighbours in
    /// the list share; keys that reach the root level from several levels may make several runs of one page.
    pub runs: [u32; 4],
}

/// Sums up a sorted list of keys in Morton form.
pub fn compact(sorted: &[(u64, u32)]) -> Compacted {
    let mut sums = BTreeMap::<u64, u32>::new();
    for &(key, value) in sorted {
        let sum = sums.entry(key).or_default();
        *sum = sum.wrapping_add(value);
    }
    let runs = SHIFTS.map(|shift| {
        let mut coarse: Vec<_> =
            sorted.iter().map(|&(key, _)| to_morton(key_ancestor(from_morton(key), shift))).collect();
        coarse.dedup();
        coarse.len() as u32
    });
    Compacted { entries: sums.into_iter().collect(), runs }
}
