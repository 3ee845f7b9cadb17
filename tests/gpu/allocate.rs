//! Allocate against its twin: tree, ranks, threshold, pages, entries.

use crate::bench::{Bench, Lcg};
use crate::comparators::same_table;
use std::collections::BTreeMap;
use umbrage::Config;
use umbrage::gpu::structs::Frame;
use umbrage::lab::stages::{AllocateStage, frame_constants};
use umbrage::twin::allocate::{Allocation, allocate};
use umbrage::twin::compact::compact;
use umbrage::twin::key::{key_ancestor, key_level, key_of, key_page};

type Requests = BTreeMap<u32, u32>;

type Drawn = fn(u32) -> bool;

const KEYS: u32 = 64;

/// Which of the selected pages may serve.
const RULES: [(&str, Drawn); 3] = [
    ("all", |_| true),
    ("coarse pages", |key| key >> 28 <= 3),
    ("every other page", |key| key.count_ones().is_multiple_of(2)),
];

fn config(pages: u64, level_bias: f32) -> Config {
    let page_texels = 64;
    Config {
        page_texels,
        atlas_bytes: pages * 4 * 64 * 64,
        request_capacity: KEYS,
        pair_capacity: 1024,
        level_bias,
        ..Config::new([64, 48])
    }
}

/// A square of neighbours, `n` in all.
fn square(level: i32, n: u32) -> Requests {
    (0..n).map(|i| (key_of(level, [64 + i % 16, 32 + i / 16]), 1 + i % 7)).collect()
}

/// Pages at random around a few places, on all levels.
fn scattered(n: u32, seed: u64) -> Requests {
    let mut lcg = Lcg(seed);
    let places: Vec<[u32; 2]> = (0..3).map(|_| [lcg.below(16384), lcg.below(16384)]).collect();
    let key = |lcg: &mut Lcg| {
        let level = lcg.below(14) as i32;
        let place = places[lcg.below(3) as usize];
        key_of(level, place.map(|c| (c >> level) ^ lcg.below(4).min((16383 >> level) & 3)))
    };
    let count = |lcg: &mut Lcg| {
        let most = 1 << (4 * lcg.below(4));
        1 + lcg.below(most)
    };
    (0..n).map(|_| (key(&mut lcg), count(&mut lcg))).collect()
}

fn cases() -> Vec<(String, Requests)> {
    let mut cases: Vec<(String, Requests)> = vec![
        ("nothing".into(), Requests::new()),
        ("a chain".into(), [(key_of(0, [9000, 77]), 5)].into()),
        ("a root".into(), [(key_of(13, [1, 0]), 5)].into()),
        ("all roots".into(), (0..4).map(|i| (key_of(13, [i & 1, i >> 1]), 1)).collect()),
        (
            "a page and its children".into(),
            [(key_of(6, [3, 3]), 9), (key_of(5, [6, 6]), 2), (key_of(5, [7, 7]), 1 << 20), (key_of(4, [13, 13]), 3)]
                .into(),
        ),
        ("one pixel against many".into(), [(key_of(0, [0, 0]), 1), (key_of(0, [16383, 16383]), 100_000)].into()),
    ];
    for n in [1, KEYS - 1, KEYS, KEYS + 1, 4 * KEYS] {
        cases.push((format!("square of {n}"), square(3, n)));
    }
    // coarsened by two levels, then to the roots
    cases.push((
        "too many for two levels".into(),
        (0..512).map(|i| (key_of(4, [7 * (i % 23), 5 * (i / 23)]), i)).collect(),
    ));
    cases.extend((1..=6).map(|seed| (format!("scattered, seed {seed}"), scattered(10 + 4 * seed as u32, seed))));
    cases
}

fn run(
    lab: &Bench,
    stage: &AllocateStage,
    frame: &Frame,
    case: &str,
    requests: &Requests,
    config: &Config,
) -> Allocation {
    let list: Vec<_> = requests.iter().map(|(&k, &c)| (k, c)).collect();
    let runs = compact(&list).runs;
    let want = allocate(requests, runs, KEYS, config.page_capacity(), config.weight_bits());
    assert!(want.pages.len() as u32 <= config.page_capacity(), "{case}: the twin overfills the atlas");
    let tolerance = (-config.level_bias).ceil().max(0.0) as i32;
    for (name, drawn) in RULES {
        let got = stage.run(lab, frame, &list, runs, drawn).unwrap();
        let served = want.serve(drawn, tolerance);
        if let Err(why) = same_table(&want, &served, &got) {
            panic!("{case}, {} pages, {name} drawn: {why}", config.page_capacity());
        }
        for page in &got.pages {
            let (level, [x, y]) = (key_level(page.key), key_page(page.key));
            let corner = [
                (frame.anchor_page[0] + ((x << level) as i32)) as f32,
                (frame.anchor_page[1] + ((y << level) as i32)) as f32,
            ];
            assert_eq!(page.origin, corner.map(|c| c * frame.page[0]), "{case}: {page:?}");
            assert_eq!(page.scale, frame.rule[3] * frame.page[1] * (-level as f32).exp2(), "{case}: {page:?}");
        }
    }
    want
}

#[test]
fn allocates_as_its_twin_does() {
    let lab = Bench::plain();
    let mut shifts = Vec::new();
    for (pages, level_bias) in [(8, 0.0), (24, -1.5), (256, 0.5)] {
        let config = config(pages, level_bias);
        let stage = AllocateStage::new(&lab, &config).unwrap();
        let frame = frame_constants(&lab, &config).unwrap();
        let mut full = 0;
        for (case, requests) in cases() {
            let want = run(&lab, &stage, &frame, &case, &requests, &config);
            let all_leaves = want.leaves.iter().all(|leaf| want.pages.contains(leaf));
            full += usize::from(!all_leaves);
            shifts.push(want.shift);
        }
        assert_eq!(full > 0, pages < 256, "{full} cases do not fit {pages} pages");
    }
    assert!([0, 2, 5].iter().all(|s| shifts.contains(s)), "{shifts:?}");
}

/// Requests so far apart that their ancestors do not fit the table: what is missing is counted, and what is served is
/// served by a page that is there. Which nodes are missing is a matter of chance.
#[test]
fn a_full_table_serves_what_it_can() {
    let lab = Bench::plain();
    let config = config(64, 0.0);
    let stage = AllocateStage::new(&lab, &config).unwrap();
    let frame = frame_constants(&lab, &config).unwrap();
    let mut lcg = Lcg(21);
    let requests: Requests =
        (0..KEYS).map(|_| (key_of(0, [lcg.below(16384), lcg.below(16384)]), 1 + lcg.below(9))).collect();
    let list: Vec<_> = requests.into_iter().collect();
    let got = stage.run(&lab, &frame, &list, compact(&list).runs, |_| true).unwrap();
    let c = &got.counters;
    assert!(c.failed > 0 && c.leaves == list.len() as u32 && c.shift == 0, "{c:?}");
    assert!((4..=config.page_capacity()).contains(&c.pages), "{c:?}");
    let pages: Vec<_> = got.pages.iter().map(|p| p.key).collect();
    assert!(
        pages.is_sorted() && (0..4).all(|root| pages[root as usize] == key_of(13, [root & 1, root >> 1])),
        "{pages:x?}"
    );
    for (key, _) in list {
        let slot = got.keys.iter().position(|&k| k == key).expect("every request is in the table");
        let entry = got.entries[slot];
        if entry != 0 {
            let (level, layer) = ((entry >> 16 & 15) as u32, (entry & 0xffff) as usize);
            assert_eq!(pages[layer], key_ancestor(key, level), "{key:x} is served by {entry:x}");
        }
    }
}

/// Pixels on one page gain more than ten on each of eight others.
fn one_page_first(pixels: u32) {
    let lab = Bench::plain();
    let config = Config { size: [pixels.div_ceil(2048), 2048], ..config(8, 0.0) };
    let stage = AllocateStage::new(&lab, &config).unwrap();
    let frame = frame_constants(&lab, &config).unwrap();
    let mut requests: Requests = (0..8).map(|i| (key_of(9, [16 + i, 3]), 10)).collect();
    requests.insert(key_of(1, [5, 5]), pixels);
    let case = format!("{pixels} pixels on one page");
    let want = run(&lab, &stage, &frame, &case, &requests, &config);
    assert!(want.pages.contains(&key_of(1, [5, 5])), "{case}: {:x?}", want.pages);
}

#[test]
fn many_pixels_are_served_first() {
    for pixels in [1 << 12, (1 << 18) + 7, (1 << 19) - 1] {
        one_page_first(pixels);
    }
}

/// A benefit of 2^28 once left the 32 bits of a rank.
#[test]
fn half_a_million_pixels_are_served_first() {
    one_page_first(1 << 19);
}

/// 2^22 pixels ten levels below once left the 32 bits of `below`.
#[test]
fn four_million_pixels_are_served_first() {
    one_page_first((1 << 22) + 1);
}
