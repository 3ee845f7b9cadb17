//! Allocate against its twin: tree, costs, ranks, thresholds, pages, entries.

use crate::bench::{Bench, Lcg};
use crate::comparators::same_table;
use std::collections::BTreeMap;
use umbrage::gpu::structs::{Frame, LightRecord, light_kind};
use umbrage::lab::stages::{AllocateStage, Table, frame_constants};
use umbrage::twin::allocate::{Allocation, Input, Service, allocate};
use umbrage::twin::key::{from_words, key_ancestor, key_face, key_level, key_of, key_page};
use umbrage::twin::{FACES, ROOT_LEVEL};
use umbrage::{Config, Pressure};

pub type Requests = BTreeMap<u64, u32>;

type Ready = fn(u64) -> bool;

pub const KEYS: u32 = 64;
/// More layers than any case draws.
pub const PLENTY: u32 = 512;
const FRAME: u32 = 9;

/// Which pages may serve.
const RULES: [(&str, Ready); 3] = [
    ("all", |_| true),
    ("coarse pages", |key| key_level(key) >= 21),
    ("every other page", |key| key.count_ones().is_multiple_of(2)),
];

pub fn config(pages: u64, level_bias: f32) -> Config {
    Config {
        page_texels: 64,
        atlas_bytes: pages * 4 * 64 * 64,
        page_table_bytes: Config::table_bytes(KEYS),
        spare_percent: 0,
        pair_capacity: 1024,
        level_bias,
        lights: 64,
        ..Config::new([64, 48])
    }
}

/// Level of a page that covers one of the four faces of [`at`]: levels there are ten finer than keys say.
const TOP: i32 = 13;

/// A page among four faces, each of a light of its own, that lie in a square: levels 0 to [`TOP`], coordinates below
/// 2^(14 - level).
fn at(level: i32, page: [u32; 2]) -> u64 {
    let bits = TOP - level;
    let face = FACES * (page[0] >> bits | page[1] >> bits << 1);
    key_of(level + 10, face, page.map(|c| c & ((1 << bits) - 1)))
}

/// What starts without anything kept; the lights of [`at`] are directional.
fn input(requests: Requests, draw_budget: u32) -> Input {
    Input { requests, directional: vec![0, 1, 2, 3], draw_budget, ..Input::default() }
}

/// A square of neighbours, `n` in all.
fn square(level: i32, n: u32) -> Requests {
    (0..n).map(|i| (at(level, [64 + i % 16, 32 + i / 16]), 1 + i % 7)).collect()
}

/// Pages at random around a few places, on all levels.
fn scattered(n: u32, seed: u64) -> Requests {
    let mut lcg = Lcg(seed);
    let places: Vec<[u32; 2]> = (0..3).map(|_| [lcg.below(16384), lcg.below(16384)]).collect();
    let key = |lcg: &mut Lcg| {
        let level = lcg.below(14) as i32;
        let place = places[lcg.below(3) as usize];
        at(level, place.map(|c| (c >> level) ^ lcg.below(4).min((16383 >> level) & 3)))
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
        ("a chain".into(), [(at(0, [9000, 77]), 5)].into()),
        ("a root".into(), [(at(TOP, [1, 0]), 5)].into()),
        ("all roots".into(), (0..4).map(|i| (at(TOP, [i & 1, i >> 1]), 1)).collect()),
        (
            "a page and its children".into(),
            [(at(6, [3, 3]), 9), (at(5, [6, 6]), 2), (at(5, [7, 7]), 1 << 20), (at(4, [13, 13]), 3)].into(),
        ),
        ("one pixel against many".into(), [(at(0, [0, 0]), 1), (at(0, [16383, 16383]), 100_000)].into()),
    ];
    for n in [1, KEYS - 1, KEYS, KEYS + 1, 4 * KEYS] {
        cases.push((format!("square of {n}"), square(3, n)));
    }
    // coarsened by two levels, then to the roots
    cases
        .push(("too many for two levels".into(), (0..512).map(|i| (at(4, [7 * (i % 23), 5 * (i / 23)]), i)).collect()));
    // the finest level and both ends of a face, next to each other and alone
    let last = (1 << 23) - 1;
    let ends = [[0, 0], [1, 0], [0, 1], [last, last], [last, last - 1], [0, last], [5_000_000, 3]];
    cases.push(("finest pages".into(), (1..).zip(ends).map(|(n, page)| (key_of(0, 6, page), n)).collect()));
    cases.extend((1..=6).map(|seed| (format!("scattered, seed {seed}"), scattered(10 + 4 * seed as u32, seed))));
    cases
}

/// A stage and what it runs with.
pub struct Rig<'a> {
    lab: &'a Bench,
    pub config: Config,
    stage: AllocateStage,
    frame: Frame,
    lights: Vec<LightRecord>,
}

impl<'a> Rig<'a> {
    fn new(lab: &'a Bench, config: Config) -> Self {
        Self::of_kinds(lab, config, &[light_kind::DIRECTIONAL; 4])
    }

    /// Lights of these kinds.
    pub fn of_kinds(lab: &'a Bench, config: Config, kinds: &[u32]) -> Self {
        let stage = AllocateStage::new(lab, &config).unwrap();
        let (mut frame, lights) = frame_constants(lab, &config).unwrap();
        frame.cache[1] = FRAME;
        frame.lights[0] = kinds.len() as u32;
        let light = |(i, &kind): (usize, &u32)| {
            let mut light = LightRecord { kind: [kind, 0, 0, 0], ..lights[0] };
            light.scale[0] = (i as f32).exp2();
            light.scale[1] = (-(i as f32)).exp2();
            light
        };
        Self { lab, config, stage, frame, lights: kinds.iter().enumerate().map(light).collect() }
    }

    /// Runs the stage with everything that is chosen serving.
    pub fn run(&self, input: &Input) -> Table {
        self.stage.run(self.lab, &self.frame, &self.lights, input, |_| true).unwrap()
    }

    /// Compares stage and twin; what the twin chose, and what serves when all that may serve does.
    pub fn check(&self, case: &str, input: &Input) -> (Allocation, Service) {
        let Self { config, frame, lights, .. } = self;
        let case =
            format!("{case}, {:?}, {} pages, {} draws", config.pressure, config.page_capacity(), input.draw_budget);
        let want = allocate(input, config);
        let tolerance = (-config.level_bias).ceil().max(0.0) as i32;
        for (name, ready) in RULES {
            let got = self.stage.run(self.lab, frame, lights, input, ready).unwrap();
            let served = want.serve(ready, tolerance);
            if let Err(why) = same_table(&want, &served, &got, FRAME) {
                panic!("{case}, {name} ready: {why}");
            }
            for page in &got.pages {
                let key = from_words(page.key);
                let (level, light) = (key_level(key), &lights[(key_face(key) / FACES) as usize]);
                let corner = key_page(key).map(|c| f64::from(c) * f64::from(level).exp2() - f64::from(1 << 22));
                assert_eq!(
                    page.origin.map(f64::from),
                    corner.map(|c| c * f64::from(light.scale[1])),
                    "{case}: {page:?}"
                );
                let scale = f64::from(frame.rule[0]) * f64::from(light.scale[0]) * f64::from(-level).exp2();
                assert_eq!(f64::from(page.scale), scale, "{case}: {page:?}");
            }
            if name == "all" {
                let spare = config.page_capacity() * config.spare_percent / 100;
                keeps_its_limits(&case, input, &want, config.page_capacity() - spare, &got);
            }
        }
        let served = want.serve(|_| true, tolerance);
        (want, served)
    }
}

/// What must hold whatever the ranks are. `want` tells only what was asked for.
fn keeps_its_limits(case: &str, input: &Input, want: &Allocation, most_layers: u32, got: &Table) {
    let keys: Vec<u64> = got.pages.iter().map(|page| from_words(page.key)).collect();
    let chosen = |key: u64| keys.binary_search(&key).is_ok();
    let root = |key: u64| key_level(key) == ROOT_LEVEL;
    // every leaf has a page, and so does every leaf below a page's parent, below that parent
    for &leaf in &want.leaves {
        let mut above = (0..24).map(|steps| key_ancestor(leaf, steps));
        let Some(serving) = above.find(|&key| chosen(key)) else {
            // only where not even all the roots have room
            assert!(got.pages.iter().all(|page| root(from_words(page.key))), "{case}: nothing serves {leaf:x}");
            continue;
        };
        let refined = keys.iter().filter(|&&key| !root(key)).map(|&key| key_ancestor(key, 1));
        for parent in refined.filter(|&p| key_ancestor(leaf, (key_level(p) - key_level(leaf)).max(0) as u32) == p) {
            let below = leaf == parent || key_level(serving) < key_level(parent);
            assert!(below, "{case}: {serving:x} serves {leaf:x}, but {parent:x} is refined");
        }
    }
    // a refined page is chosen only where pixels ask for it
    for &key in keys.iter().filter(|&&key| !root(key)) {
        let refined = keys
            .iter()
            .any(|&k| key_level(k) < key_level(key) && key_ancestor(k, (key_level(key) - key_level(k)) as u32) == key);
        assert!(!refined || want.leaves.contains(&key), "{case}: {key:x} is refined and chosen");
    }
    let moving = |key: &&u64| input.moving.contains(key);
    let layers = keys.len() + keys.iter().filter(moving).count();
    // what stands in for a page that was put off may take a layer more; cache_assign then refuses the last pages
    let spared = if got.counters.deferred > 0 { 2 } else { 0 };
    assert!(layers <= most_layers as usize + spared, "{case}: {layers} layers");
    let draws = got.pages.iter().map(|page| page.draws.count_ones()).sum::<u32>();
    let c = &got.counters;
    assert!(draws <= input.draw_budget, "{case}: {draws} layers drawn");
    assert_eq!(c.draws_asked, draws + c.deferred, "{case}: {c:?}");
    assert_eq!(c.deferred > 0, c.draws_asked > input.draw_budget, "{case}: {c:?}");
    let held = keys.iter().filter(|key| input.held.iter().any(|held| held.0 == **key)).count() as u32;
    assert_eq!(c.hits + c.stale, held, "{case}: {c:?}");
}

#[test]
fn allocates_as_its_twin_does() {
    let lab = Bench::plain();
    let mut shifts = Vec::new();
    for (pages, level_bias) in [(16, 0.0), (24, -1.5), (256, 0.5)] {
        let rig = Rig::new(&lab, config(pages, level_bias));
        let mut full = 0;
        for (case, requests) in cases() {
            let (want, _) = rig.check(&case, &input(requests, PLENTY));
            full += usize::from(!want.leaves.iter().all(|&leaf| want.chose(leaf)));
            shifts.push(want.shift);
        }
        assert_eq!(full > 0, pages < 256, "{full} cases do not fit {pages} pages");
    }
    assert!([0, 2, 5].iter().all(|s| shifts.contains(s)), "{shifts:?}");
}

/// Pages of the quadtree and some beyond it held, right or stale; casters that move on a few and on all above these. At
/// seed 2 all pages are held and right and nothing moves.
fn kept(requests: Requests, draw_budget: u32, config: &Config, seed: u64) -> Input {
    let mut lcg = Lcg(seed);
    let mut input = input(requests, draw_budget);
    let nodes: Vec<u64> = allocate(&input, config).nodes.into_keys().collect();
    let settled = seed == 2;
    let one_in = if settled { 1 } else { 1 + lcg.below(3) };
    let mut held: Vec<u64> = nodes.iter().copied().filter(|_| lcg.below(one_in) == 0).collect();
    held.extend((0..3).map(|i| at(2, [4000 + i, 7])));
    for i in (1..held.len()).rev() {
        held.swap(i, lcg.below(i as u32 + 1) as usize);
    }
    held.truncate(config.page_capacity() as usize);
    input.held = held.into_iter().map(|key| (key, settled || lcg.below(4) > 0)).collect();
    for _ in 0..if settled { 0 } else { lcg.below(6) } {
        let touched = nodes[lcg.below(nodes.len() as u32) as usize];
        input.moving.extend((0..24).map(|steps| key_ancestor(touched, steps)));
    }
    input
}

#[test]
fn allocates_kept_pages_as_its_twin_does() {
    let lab = Bench::plain();
    let mut seen = BTreeMap::<&str, u32>::new();
    for pressure in [Pressure::Demand, Pressure::Histogram, Pressure::Level] {
        for (pages, spare_percent) in [(16, 0), (40, 10), (256, 50)] {
            let rig = Rig::new(&lab, Config { pressure, spare_percent, ..config(pages, -0.5) });
            for seed in 1..=8 {
                let requests = if seed % 4 == 0 { square(3, KEYS) } else { scattered(15 * (seed as u32 % 4), seed) };
                for draw_budget in [16, 24, 60, PLENTY] {
                    let case = format!("kept, seed {seed}");
                    let (want, served) = rig.check(&case, &kept(requests.clone(), draw_budget, &rig.config, seed));
                    let layers = want.pages.iter().map(|page| page.slot);
                    let others = |entry: u32| layers.clone().all(|layer| layer != entry & 0xfff);
                    let happened = [
                        ("hit", want.hits > 0),
                        ("stale", want.stale > 0),
                        ("moving", want.pages.iter().any(|page| page.draws > 1)),
                        ("atlas full", want.threshold > 1),
                        ("put off", want.deferred > 0),
                        ("both", want.threshold > 1 && want.deferred > 0),
                        ("nothing drawn", want.draws_asked == 0),
                        ("served by a page not chosen", served.entries.values().any(|&entry| others(entry))),
                    ];
                    for (what, yes) in happened {
                        *seen.entry(what).or_default() += u32::from(yes);
                    }
                }
            }
        }
    }
    assert!(seen.values().all(|&n| n > 0), "{seen:?}");
}

/// Putting off a page that moving casters touch takes a layer more than the one page below it.
#[test]
fn a_page_that_stands_in_may_need_a_layer_more() {
    let lab = Bench::plain();
    let rig = Rig::new(&lab, Config { pressure: Pressure::Level, ..config(21, 0.0) });
    // below the first root a moving page, a moving page below that and one that stands still, the only one asked for
    let chain: Vec<u64> = (10..=TOP).map(|level| at(level, [0, 0])).collect();
    // one new page below each of two that are held
    let (old, new) = ([[2, 0], [2, 1]].map(|p| at(12, p)), [[4, 0], [4, 2]].map(|p| at(11, p)));
    let fillers = (0..16).map(|i| at(12, [i & 3, i >> 2])).filter(|key| !old.contains(key) && *key != chain[2]);
    let input = Input {
        requests: fillers.chain(new).chain([chain[0]]).map(|key| (key, 1)).collect(),
        held: [chain[0], chain[2], chain[3], old[0], old[1]].map(|key| (key, true)).into(),
        moving: chain[1..].iter().copied().collect(),
        ..input(Requests::new(), 18)
    };
    rig.check("a chain put off", &input);
}

/// Requests so far apart that their ancestors do not fit the table: what is missing is counted, and what is served is
/// served by a page that is there. Which nodes are missing is a matter of chance.
#[test]
fn a_full_table_serves_what_it_can() {
    let lab = Bench::plain();
    let rig = Rig::new(&lab, config(64, 0.0));
    let mut lcg = Lcg(21);
    let requests: Requests =
        (0..KEYS).map(|_| (at(0, [lcg.below(16384), lcg.below(16384)]), 1 + lcg.below(9))).collect();
    let input = input(requests, PLENTY);
    let got = rig.run(&input);
    let c = &got.counters;
    assert!(c.failed > 0 && c.leaves == input.requests.len() as u32 && c.shift == 0, "{c:?}");
    assert!((4..=rig.config.page_capacity()).contains(&c.pages), "{c:?}");
    let pages: Vec<_> = got.pages.iter().map(|p| from_words(p.key)).collect();
    assert!(
        pages.is_sorted() && (0..4).all(|root| pages[root as usize] == at(TOP, [root & 1, root >> 1])),
        "{pages:x?}"
    );
    for key in input.requests.into_keys() {
        let slot = got.keys.iter().position(|&k| k == key).expect("every request is in the table");
        let entry = got.entries[slot];
        if entry != 0 {
            let (level, layer) = (entry >> 26 & 31, entry & 0xfff);
            let serving = got.pages.iter().find(|page| page.slot == layer).expect("a page has the layer");
            assert_eq!(
                from_words(serving.key),
                key_ancestor(key, level - key_level(key) as u32),
                "{key:x} is served by {entry:x}"
            );
        }
    }
}

/// Pixels on one page gain more than ten on each of eight others.
fn one_page_first(pixels: u32) {
    let lab = Bench::plain();
    let size = [pixels.div_ceil(2048), 2048];
    let rig = Rig::new(&lab, Config { size, ..config(16, 0.0) });
    let mut requests: Requests = (0..8).map(|i| (at(9, [16 + i, 3]), 10)).collect();
    requests.insert(at(1, [5, 5]), pixels);
    let case = format!("{pixels} pixels on one page");
    let (want, _) = rig.check(&case, &input(requests, PLENTY));
    assert!(want.chose(at(1, [5, 5])), "{case}: {:x?}", want.pages);
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
