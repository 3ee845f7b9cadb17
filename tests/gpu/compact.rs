//! Compact against its twin.

use crate::bench::{Bench, Lcg};
use crate::comparators::same_entries;
use umbrage::lab::stages::SortStage;
use umbrage::twin::key::{from_morton, key_ancestor, key_of, to_morton};
use umbrage::twin::{self, BLOCK};

const CAPACITY: u32 = 4096;

/// Name and keys of lists that are sorted before use; no key is 0.
fn cases() -> Vec<(String, Vec<u64>)> {
    let mut cases = Vec::new();
    for n in [0, 1, 8, 9, 64, 65, BLOCK - 1, BLOCK, BLOCK + 1, CAPACITY - 1, CAPACITY] {
        cases.push((format!("{n} equal"), vec![key_of(3, 5, [5, 6]); n as usize]));
        cases.push((format!("{n} distinct"), (0..n).map(|i| key_of(2, i % 7, [i % 64, i / 64])).collect()));
        for (seed, distinct) in [(1, 3), (2, 40), (3, 1000)] {
            let mut lcg = Lcg(seed);
            let key = |lcg: &mut Lcg| key_of(1 + lcg.below(6) as i32, lcg.below(3), [lcg.below(distinct), 1 << 16]);
            let keys = (0..n).map(|_| key(&mut lcg)).collect();
            cases.push((format!("{n} keys, seed {seed}"), keys));
        }
    }
    // runs that end exactly at, one before and one after a thread's share and a block
    for run in [7, 8, 9, BLOCK - 1, BLOCK, BLOCK + 1] {
        cases.push((format!("runs of {run}"), (0..CAPACITY).map(|i| key_of(4, 8190, [i / run, 0])).collect()));
    }
    let every_level =
        (0..23).flat_map(|level| [0, 1].map(|x| key_of(level, x, [x, 1]))).chain([key_of(23, 3, [0, 0])]).collect();
    cases.push(("all levels".into(), every_level));
    let last = (1 << 23) - 1;
    let ends = [[last, last], [0, last], [last, 0], [last - 1, last]];
    cases.push(("finest pages".into(), ends.map(|page| key_of(0, 1, page)).into()));
    cases
}

#[test]
fn compacts_as_its_twin_does() {
    let lab = Bench::plain();
    let stage = SortStage::new(&lab, CAPACITY).unwrap();
    for (case, mut keys) in cases() {
        keys.iter_mut().for_each(|key| *key = to_morton(*key));
        keys.sort_unstable();
        let sorted: Vec<_> = keys.into_iter().zip((1..).step_by(3)).collect();
        let want = twin::compact::compact(&sorted);
        let got = stage.compact(&lab, &sorted).unwrap();
        assert_eq!(got.runs, want.runs, "{case}");
        if sorted.is_empty() {
            assert!(got.entries.is_empty(), "{case}");
        } else if let Err(why) = same_entries(&want.entries, &got.entries) {
            panic!("{case}: {why}");
        }
    }
}

/// Runs may exceed the distinct keys, but only by root pages that several levels reach.
#[test]
fn runs_are_distinct_keys_but_for_the_root_level() {
    for (case, mut keys) in cases() {
        keys.iter_mut().for_each(|key| *key = to_morton(*key));
        keys.sort_unstable();
        let sorted: Vec<_> = keys.iter().map(|&k| (k, 1)).collect();
        let runs = twin::compact::compact(&sorted).runs;
        for (i, shift) in twin::SHIFTS.into_iter().enumerate() {
            let distinct: std::collections::BTreeSet<_> =
                keys.iter().map(|&k| key_ancestor(from_morton(k), shift)).collect();
            let distinct = distinct.len() as u32;
            let faces =
                keys.iter().map(|key| key >> 46 & 0x1fff).collect::<std::collections::BTreeSet<_>>().len() as u32;
            assert!((distinct..=distinct + faces * shift).contains(&runs[i]), "{case}: {} runs of {distinct}", runs[i]);
        }
    }
}
