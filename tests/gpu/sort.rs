//! Sort against its twin.

use crate::bench::{Bench, Lcg};
use crate::comparators::same_entries;
use umbrage::lab::stages::SortStage;
use umbrage::twin::{self, BLOCK};

/// Lengths at which threads, groups, blocks and capacities begin and end.
fn lengths(capacity: u32) -> Vec<u32> {
    let mut all = vec![
        0,
        1,
        7,
        8,
        9,
        63,
        64,
        65,
        BLOCK - 1,
        BLOCK,
        BLOCK + 1,
        2 * BLOCK + 1,
        capacity - 1,
        capacity,
        capacity + 1,
    ];
    all.sort_unstable();
    all.dedup();
    all
}

type Keys = fn(u32, u32, &mut Lcg) -> u64;

/// Any key of two words.
fn any(lcg: &mut Lcg) -> u64 {
    u64::from(lcg.word()) << 32 | u64::from(lcg.word())
}

/// Name and key of entry `i` of `n`.
const PATTERNS: [(&str, Keys); 8] = [
    ("random", |_, _, lcg| any(lcg)),
    ("low word", |_, _, lcg| u64::from(lcg.word()) | 5 << 40),
    ("high word", |_, _, lcg| u64::from(lcg.word()) << 32 | 7),
    ("equal", |_, _, _| 0x7f00_0001_0000_0002),
    ("reverse", |i, n, _| u64::from(n - i) << 24),
    ("few", |_, _, lcg| u64::from(1 + lcg.below(5)) << 30),
    ("top digit", |_, _, lcg| any(lcg) << 60 | 1),
    ("zeros and ones", |i, _, _| if i % 3 == 0 { u64::MAX } else { 0 }),
];

pub fn entries(n: u32, key: Keys, seed: u64) -> Vec<(u64, u32)> {
    let mut lcg = Lcg(seed);
    (0..n).map(|i| (key(i, n, &mut lcg), i.wrapping_mul(0x9e37_79b1) | 1)).collect()
}

fn check(lab: &Bench, stage: &SortStage, capacity: u32, case: &str, entries: &[(u64, u32)]) {
    let want = twin::sort::sort(entries, capacity as usize);
    let got = stage.sort(lab, entries).unwrap();
    if want.is_empty() {
        assert!(got.is_empty(), "{case}: {got:?}");
    } else if let Err(why) = same_entries(&want, &got) {
        panic!("{case}: {why}");
    }
}

#[test]
fn sorts_as_its_twin_does() {
    let lab = Bench::plain();
    for capacity in [4096, 1500, 300] {
        let stage = SortStage::new(&lab, capacity).unwrap();
        for n in lengths(capacity) {
            for (seed, (name, key)) in (1..).zip(PATTERNS) {
                let case = format!("capacity {capacity}, {n} entries, {name}, seed {seed}");
                check(&lab, &stage, capacity, &case, &entries(n, key, seed));
            }
        }
    }
}

/// The scan's one workgroup has several blocks a thread.
#[test]
fn sorts_long_lists() {
    let lab = Bench::plain();
    let stage = SortStage::new(&lab, 200_000).unwrap();
    for (seed, n) in [(11, 199_999), (12, 100_003)] {
        check(&lab, &stage, 200_000, &format!("{n} entries, seed {seed}"), &entries(n, |_, _, lcg| any(lcg), seed));
    }
}
