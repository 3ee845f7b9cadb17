//! Whole frames: the same bits again, the same pages on both routes, an answer for every pixel when space runs out.

use crate::bench::Bench;
use crate::comparators::{mixed, same_image};
use crate::scenes;
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};
use umbrage::lab::View;
use umbrage::lab::stages::{EngineStage, Table};
use umbrage::scene::Scene;
use umbrage::twin::ROOT_LEVEL;
use umbrage::twin::key::{from_words, key_ancestor, key_level};
use umbrage::{Config, Light, RequestRoute};

const SIZE: [u32; 2] = [320, 180];

/// The defaults, but whatever is needed is drawn at once.
fn config() -> Config {
    Config { pages_per_frame: 4096, ..Config::new(SIZE) }
}

fn frame(lab: &Bench, config: &Config) -> (Vec<f32>, Table) {
    EngineStage::new(lab, config).unwrap().frame(lab).unwrap()
}

/// What a page table says, without the slots, whose order is a matter of chance.
#[derive(Debug, PartialEq)]
struct Said {
    entries: BTreeMap<u64, u32>,
    pages: BTreeMap<u64, Option<u32>>,
    levels: [[u32; 24]; 3],
    drawn: [u32; 5],
}

fn said(table: &Table) -> Said {
    let c = &table.counters;
    assert!(c.leaves > 0 && c.pages > 0, "nothing to compare: {c:?}");
    Said {
        entries: table.keys.iter().copied().zip(table.entries.iter().copied()).filter(|e| e.0 != 0).collect(),
        pages: table.pages.iter().map(|p| (from_words(p.key), (p.admitted == 1).then_some(p.slot))).collect(),
        levels: [c.requested, c.resident, c.refused],
        drawn: [c.shift, c.admitted, c.pairs_opaque, c.pairs_masked, c.triangles],
    }
}

/// Every node's entry names itself or its nearest ancestor that is drawn, and that page has the right key.
fn entries_lead_to_pages(table: &Table) {
    let said = said(table);
    for (&key, &entry) in &said.entries {
        assert_eq!(entry >> 31, 1, "{key:x} has no entry");
        let (level, layer) = ((entry >> 26 & 31) as i32, entry & 0xfff);
        let serving = key_ancestor(key, (level - key_level(key)) as u32);
        assert_eq!(said.pages.get(&serving), Some(&Some(layer)), "{key:x} is served by {entry:x}");
        for steps in 0..(level - key_level(key)) as u32 {
            let finer = key_ancestor(key, steps);
            assert!(
                said.pages.get(&finer).is_none_or(Option::is_none),
                "{key:x} is served by {entry:x} although {finer:x} is drawn"
            );
        }
    }
    assert_eq!(table.counters.resident.iter().sum::<u32>(), table.counters.admitted);
    assert_eq!(table.counters.requested.iter().sum::<u32>(), table.counters.leaves);
    assert_eq!(said.pages.values().flatten().count() as u32, table.counters.admitted);
}

fn both_routes_agree(name: &str, (scene, view): (Scene, View), configs: &[Config]) {
    let lab = Bench::new(scene, view);
    for config in configs {
        let flags = frame(&lab, &Config { route: RequestRoute::Flags, ..config.clone() });
        let sort = frame(&lab, &Config { route: RequestRoute::Sort, ..config.clone() });
        entries_lead_to_pages(&flags.1);
        assert_eq!(said(&flags.1), said(&sort.1), "{name}, {config:?}");
        same_image(&flags.0, &sort.0).unwrap_or_else(|why| panic!("{name}, {config:?}: {why}"));
    }
}

#[test]
fn both_routes_give_the_same_frame() {
    let plenty = config();
    let tight = Config { atlas_bytes: 2 << 20, ..plenty.clone() };
    // more than 1024 pages are asked for; a quarter by a quarter of them are not
    let coarsened = Config { level_bias: -4.0, page_table_bytes: Config::table_bytes(1 << 10), ..plenty.clone() };
    both_routes_agree("street", scenes::street(SIZE), &[plenty.clone(), tight, coarsened]);
    let (scene, view) = scenes::sphere_on_plane(SIZE);
    let lights = crate::lights::mixed_lights();
    let config = Config { lights: lights.len() as u32, level_bias: -1.0, ..config() };
    let pressed = Config { atlas_bytes: 2 << 20, ..config.clone() };
    both_routes_agree("lights", (scene, View { lights, ..view }), &[config, pressed]);
    for seed in [1, 2, 3] {
        both_routes_agree(&format!("random, seed {seed}"), scenes::random(SIZE, seed), std::slice::from_ref(&plenty));
    }
}

#[test]
fn both_routes_agree_when_every_pixel_has_a_page_of_its_own() {
    let (scene, view) = scenes::street(SIZE);
    let lab = Bench::new(scene, view);
    let shift = |route| {
        let config = Config { level_bias: -8.0, page_table_bytes: Config::table_bytes(1 << 16), route, ..config() };
        frame(&lab, &config).1.counters.shift
    };
    assert_eq!(shift(RequestRoute::Flags), shift(RequestRoute::Sort), "bias -8");
}

#[test]
fn the_same_frame_has_the_same_bits() {
    for (scene, view) in [scenes::street(SIZE), scenes::random(SIZE, 4)] {
        let lab = Bench::new(scene, view);
        for route in [RequestRoute::Flags, RequestRoute::Sort] {
            let config = Config { route, atlas_bytes: 4 << 20, ..config() };
            let mut engine = EngineStage::new(&lab, &config).unwrap();
            let first = engine.frame(&lab).unwrap();
            for (what, again) in [("again", engine.frame(&lab).unwrap()), ("a fresh engine", frame(&lab, &config))] {
                // a cached frame draws nothing again
                let drawn = said(&first.1).drawn;
                assert_eq!(said(&first.1), Said { drawn, ..said(&again.1) }, "{route:?}, {what}");
                same_image(&first.0, &again.0).unwrap_or_else(|why| panic!("{route:?}, {what}: {why}"));
            }
        }
    }
}

#[test]
fn every_pixel_has_an_answer_when_space_runs_out() {
    let plenty = config();
    let (scene, view) = scenes::street(SIZE);
    let least = least_pairs(&scene).max(1024);
    let cases = [
        ("atlas", Config { atlas_bytes: 1 << 20, ..plenty.clone() }),
        ("least atlas", Config { atlas_bytes: 1 << 18, page_texels: 64, ..plenty.clone() }),
        ("pairs", Config { pair_capacity: least, ..plenty.clone() }),
        ("indices", Config { index_capacity: 0, ..plenty.clone() }),
        ("keys", Config { page_table_bytes: Config::table_bytes(1 << 10), level_bias: -8.0, ..plenty.clone() }),
    ];
    let lab = Bench::new(scene, view);
    let (best, _) = frame(&lab, &plenty);
    for (name, config) in cases {
        let (visibility, table) = frame(&lab, &config);
        let c = table.counters;
        mixed(&visibility).unwrap_or_else(|why| panic!("{name}: {why}"));
        assert_eq!((c.resident[ROOT_LEVEL as usize], c.starved), (1, 0), "{name}: the root answers for everything");
        entries_lead_to_pages(&table);
        match name {
            "indices" => {
                assert!(c.indices > config.index_capacity, "{name}: {c:?}");
                same_image(&best, &visibility).unwrap_or_else(|why| panic!("{name}: {why}"));
            }
            "keys" => assert!(c.shift > 0, "{name}: {c:?}"),
            _ => assert!(c.refused.iter().sum::<u32>() > 0, "{name}: {c:?}"),
        }
        match name {
            "pairs" => assert!(
                c.admitted < c.pages && c.pairs_opaque + c.pairs_masked <= least && c.pairs_asked > least,
                "{name}: {c:?}"
            ),
            _ => assert!(c.admitted == c.pages && c.pages <= config.page_capacity(), "{name}: {c:?}"),
        }
    }
}

/// The least budget of pairs: all casters on both layers of a page.
fn least_pairs(scene: &Scene) -> u32 {
    2 * scene.meshes.iter().filter(|m| m.casts).map(|m| m.cluster_count * m.instance_count).sum::<u32>()
}

/// Pairs lie page by page, name drawn pages only, and hold no caster twice.
#[test]
fn pairs_are_those_of_the_pages_drawn() {
    let (scene, view) = scenes::street(SIZE);
    let least = least_pairs(&scene).max(1024);
    let lab = Bench::new(scene, view);
    for pair_capacity in [least, least + 500, 131_072] {
        let config = Config { pair_capacity, ..config() };
        let mut engine = EngineStage::new(&lab, &config).unwrap();
        let (_, table) = engine.frame(&lab).unwrap();
        let all = engine.pairs(&lab).unwrap();
        let drawn: BTreeSet<u32> = (0..).zip(&table.pages).filter(|(_, p)| p.admitted == 1).map(|(i, _)| i).collect();
        assert_eq!(drawn.len() < table.pages.len(), pair_capacity < 131_072, "{:?}", table.counters);
        let sum = all.iter().map(|pairs| pairs.len() as u32).sum::<u32>();
        assert!(!all[0].is_empty() && !all[1].is_empty() && sum <= pair_capacity, "{sum} pairs");
        for pairs in &all {
            assert!(pairs.is_sorted_by_key(|pair| pair[0]), "{pair_capacity}: pages out of order");
            assert!(
                pairs.iter().all(|pair| drawn.contains(&(pair[0] / 2))),
                "{pair_capacity}: a pair of a page that is not drawn"
            );
            let distinct: BTreeSet<_> = pairs.iter().collect();
            assert_eq!(distinct.len(), pairs.len(), "{pair_capacity}: a caster twice");
        }
    }
}

/// A scene at 100 km from the world's origin, whose buffers and camera are given relative to its own, is the same scene.
#[test]
fn a_hundred_kilometres_away_is_as_near() {
    let far = DVec3::new(100_000.0, 250.0, -70_000.0);
    let sun = Light::directional(DVec3::new(0.4, -1.0, 0.3));
    for light in [sun, Light::Point { position: DVec3::new(-2.5, 5.0, 1.5), range: 20.0 }] {
        for exact in [false, true] {
            let config = Config { exact, ..config() };
            let (scene, view) = scenes::street(SIZE);
            let near = Bench::new(scene, View { lights: vec![light.clone()], ..view });
            let (mut scene, mut view) = (near.scene().clone(), near.view().clone());
            for corner in [&mut scene.origin, &mut scene.bounds_min, &mut scene.bounds_max, &mut view.camera.eye] {
                *corner += far;
            }
            view.camera.target += far;
            if let Light::Point { position, .. } = &mut view.lights[0] {
                *position += far;
            }
            let want = frame(&near, &config).0;
            mixed(&want).unwrap();
            let got = frame(&Bench::new(scene, view), &config).0;
            // double precision leaves 1e-11 of such coordinates
            let differ = want.iter().zip(&got).filter(|(want, got)| want != got).count();
            assert!(differ <= 4 && want.len() == got.len(), "{light:?}, exact {exact}: {differ} pixels differ");
        }
    }
}
