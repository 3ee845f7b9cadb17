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

type Keys = fn(u32, u32, &mut Lcg) -> u32;

/// Name and key of entry `i` of `n`.
const PATTERNS: [(&str, Keys); 6] = [
    ("random", |_, _, lcg| lcg.word()),
    ("equal", |_, _, _| 0x7f00_0001),
    ("reverse", |i, n, _| n - i),
    ("few", |_, _, lcg| 1 + lcg.below(5)),
    ("top digit", |_, _, lcg| lcg.word() << 28 | 1),
    ("zeros and ones", |i, _, _| if i % 3 == 0 { u32::MAX } else { 0 }),
];

pub fn entries(n: u32, key: Keys, seed: u64) -> Vec<(u32, u32)> {
    let mut lcg = Lcg(seed);
    (0..n).map(|i| (key(i, n, &mut lcg), i.wrapping_mul(0x9e37_79b1) | 1)).collect()
}

fn check(lab: &Bench, stage: &SortStage, capacity: u32, case: &str, entries: &[(u32, u32)]) {
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
    for (capacity, pages) in [(4096, false), (1500, false), (300, true)] {
        let stage = SortStage::new(&lab, capacity, pages).unwrap();
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
    let stage = SortStage::new(&lab, 200_000, false).unwrap();
    for (seed, n) in [(11, 199_999), (12, 100_003)] {
        check(&lab, &stage, 200_000, &format!("{n} entries, seed {seed}"), &entries(n, |_, _, lcg| lcg.word(), seed));
    }
}
