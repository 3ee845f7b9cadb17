//! Request against its twin, on both routes, within and beyond the capacity.

use crate::bench::Bench;
use crate::comparators::same_requests;
use crate::gradient::noise;
use crate::scenes;
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;
use umbrage::gpu::structs::{Frame, LightRecord};
use umbrage::lab::stages::{ScreenStage, Seen, frame_constants, prepass};
use umbrage::twin::key::{from_morton, key_level, key_page};
use umbrage::twin::request::{Requests, attempts};
use umbrage::{Config, LevelRule, RequestRoute, twin};

/// Name, depth and receivers of one frame.
pub type Input = (String, Vec<f32>, Vec<[u32; 4]>);

/// What the capacity of each route counts.
fn asked(route: RequestRoute) -> fn(&Requests) -> u32 {
    match route {
        RequestRoute::Flags => |r| r.pixels.len() as u32,
        RequestRoute::Sort => |r| r.entries,
    }
}

/// A frame and its lights.
pub type Shot = (Frame, Vec<LightRecord>);

/// The greatest number of attempts after the first.
pub fn check(lab: &Bench, route: RequestRoute, capacity: u32, (frame, lights): &Shot, inputs: &[Input]) -> usize {
    let size = [frame.size[0], frame.size[1]];
    let stage = ScreenStage::new(lab, size, route, capacity, lights.len() as u32).unwrap();
    let mut deepest = 0;
    for (name, depth, receiver) in inputs {
        let case = format!("{name}, {route:?}, capacity {capacity}");
        let made = attempts(frame, lights, depth, receiver, capacity, asked(route));
        let got = stage.request(lab, frame, lights, depth, receiver).unwrap();
        let c = got.counters;
        for (i, want) in made.iter().enumerate() {
            // an attempt that overflows counts on, until the page table is full
            let (counted, mut asked) = (c.requests[i], asked(route)(want));
            if route == RequestRoute::Flags && asked >= 4 * capacity {
                asked = 4 * capacity;
            }
            let near = 2 * want.near.len() as u32;
            // the flags route stops inserting once it knows that the attempt failed
            if route == RequestRoute::Flags && asked > capacity + near {
                assert!(counted > capacity, "{case}: attempt {i} counted {counted}, not over {capacity}");
                continue;
            }
            assert!(counted.abs_diff(asked) <= near, "{case}: attempt {i} counted {counted}, not {asked}");
        }
        assert_eq!(c.failed, 0, "{case}: failures of attempts that were given up do not count");
        assert_eq!(c.requests[made.len()..], [0; 4][made.len()..], "{case}: attempts that were not needed");
        assert_eq!(c.shift, twin::SHIFTS[made.len() - 1], "{case}");
        if route == RequestRoute::Flags {
            assert_eq!(c.leaves, c.requests[made.len() - 1], "{case}: leaves");
            assert_eq!(got.entries.len(), c.leaves as usize, "{case}");
        }
        let mut sums = BTreeMap::new();
        for (key, count) in got.entries {
            let key = if route == RequestRoute::Sort { from_morton(key) } else { key };
            *sums.entry(key).or_default() += count;
        }
        let want = made.last().unwrap();
        if want.pixels.is_empty() {
            assert!(sums.is_empty(), "{case}: {sums:x?}");
        } else if let Err(why) = same_requests(want, &sums) {
            panic!("{case}: {why}");
        }
        deepest = deepest.max(made.len() - 1);
    }
    deepest
}

pub fn inputs(lab: &Bench, (frame, _): &Shot, with_scene: bool) -> Vec<Input> {
    let size = [frame.size[0], frame.size[1]];
    let stage = ScreenStage::new(lab, size, RequestRoute::Flags, 1024, 1).unwrap();
    let mut images: Vec<_> = (1..=2).map(|seed| (format!("noise, seed {seed}"), noise(frame, seed, true))).collect();
    images.push(("nothing".into(), (vec![0.0; images[0].1.0.len()], vec![0; images[0].1.0.len()])));
    if with_scene {
        images.push(("scene".into(), prepass(lab).unwrap()));
    }
    let receivers = |(name, (depth, normal)): (String, (Vec<f32>, Vec<u32>))| {
        let seen = stage.gradient(lab, frame, &depth, Some(&normal)).unwrap();
        (name, seen.depth, seen.planes)
    };
    images.into_iter().map(receivers).collect()
}

#[test]
fn pixels_ask_for_the_pages_of_their_twins() {
    let size = [320, 180];
    let (scene, view) = scenes::street(size);
    let lab = Bench::new(scene, view);
    for (level_rule, level_bias) in [(LevelRule::MinLength, -3.0), (LevelRule::Area, 0.0)] {
        let config = Config { level_rule, level_bias, ..Config::new(size) };
        let frame = frame_constants(&lab, &config).unwrap();
        let all = inputs(&lab, &frame, true);
        for (route, capacity) in [(RequestRoute::Flags, 65536), (RequestRoute::Sort, 65536)] {
            assert_eq!(check(&lab, route, capacity, &frame, &all), 0);
        }
    }
}

/// Sizes that do not fill a group of 8x8 pixels.
#[test]
fn small_images_ask_for_the_pages_of_their_twins() {
    for size in [[1, 1], [7, 9], [8, 8], [17, 8]] {
        let (scene, view) = scenes::sphere_on_plane(size);
        let lab = Bench::new(scene, view);
        let frame = frame_constants(&lab, &Config::new(size)).unwrap();
        let all = inputs(&lab, &frame, true);
        for route in [RequestRoute::Flags, RequestRoute::Sort] {
            check(&lab, route, 1024, &frame, &all);
        }
    }
}

/// Capacities at which one coarser attempt helps, and at which only the root pages fit.
#[test]
fn too_many_requests_are_coarsened_as_by_their_twins() {
    let size = [96, 64];
    let (scene, view) = scenes::sphere_on_plane(size);
    let lab = Bench::new(scene, view);
    let config = Config { level_bias: -6.0, ..Config::new(size) };
    let frame = frame_constants(&lab, &config).unwrap();
    let all = inputs(&lab, &frame, true);
    for route in [RequestRoute::Flags, RequestRoute::Sort] {
        let mut seen = [false; 4];
        // the list has room for the root from each group, as the engine's always has
        let least = if route == RequestRoute::Flags { 64 } else { 512 };
        for capacity in [64, 128, 256, 512, 1024, 2048, 4096, 8192].into_iter().filter(|&c| c >= least) {
            for input in &all {
                seen[check(&lab, route, capacity, &frame, std::slice::from_ref(input))] = true;
            }
        }
        assert_eq!(seen, [true; 4], "{route:?}: attempts that were the last");
    }
}

/// As many keys as fit are not too many; one more are.
#[test]
fn capacity_is_what_fits() {
    let size = [96, 64];
    let (scene, view) = scenes::sphere_on_plane(size);
    let lab = Bench::new(scene, view);
    let frame = frame_constants(&lab, &Config::new(size)).unwrap();
    let (name, depth, receiver) = inputs(&lab, &frame, true).pop().unwrap();
    let entries = twin::request::request(&frame.0, &frame.1, &depth, &receiver, 0);
    assert!(entries.near.is_empty() && entries.entries > 64, "{entries:?}");
    let all = [(name, depth, receiver)];
    for (capacity, attempts) in [(entries.entries + 1, 0), (entries.entries, 0), (entries.entries - 1, 1)] {
        assert_eq!(check(&lab, RequestRoute::Sort, capacity, &frame, &all), attempts);
    }
}

/// Independent of the shaders' arithmetic: a pixel's page contains its world position, and the page's texels are as large
/// as the level rule says.
#[test]
fn pages_hold_the_pixels_at_the_resolution_asked_for() {
    let size = [320, 180];
    let (scene, view) = scenes::sphere_on_plane(size);
    let lab = Bench::new(scene, view);
    let g = lab.gbuffer().unwrap();
    let (depth, normal) = prepass(&lab).unwrap();
    for (level_rule, level_bias) in [(LevelRule::MinLength, -2.0), (LevelRule::MinLength, 1.0), (LevelRule::Area, 0.0)]
    {
        let config = Config { level_rule, level_bias, ..Config::new(size) };
        let (frame, lights) = frame_constants(&lab, &config).unwrap();
        let light = &lights[0];
        let stage = ScreenStage::new(&lab, size, RequestRoute::Flags, 1024, 1).unwrap();
        let Seen { depth, planes: receiver } = stage.gradient(&lab, &frame, &depth, Some(&normal)).unwrap();
        let (page_side, texels) = (f64::from(light.scale[1]), f64::from(frame.rule[0]));
        let across = |i: usize| {
            let p = g.point(i);
            let axis = |[x, y, z, _]: [f32; 4]| DVec3::from([x, y, z].map(f64::from)).dot(p);
            DVec2::new(axis(light.axis_x), axis(light.axis_y))
        };
        let (mut checked, mut wrong) = (0, 0);
        for i in (0..g.hit.len() - size[0] as usize).filter(|i| i % size[0] as usize + 1 < size[0] as usize) {
            let [right, below] = [i + 1, i + size[0] as usize];
            if normal[i] != normal[right] || normal[i] != normal[below] || !g.hit[i] {
                continue;
            }
            let pixel = [i as u32 % size[0], i as u32 / size[0]];
            let (key, _) = twin::request::pixel_keys(&frame, 0, light, pixel, depth[i], receiver[i], 0);
            if key == 0 {
                continue;
            }
            let (level, page) = (key_level(key), key_page(key));
            let (at, dx, dy) = (across(i), across(right) - across(i), across(below) - across(i));
            let side = page_side * f64::from(level).exp2();
            // pages count from the corner of a face of 2^23 level-0 pages a side, the origin in its middle
            let middle = f64::from(22 - level).exp2();
            let inside = [0, 1].map(|axis| at[axis] / side + middle - f64::from(page[axis]));
            assert!(inside.iter().all(|v| (-1e-2..1.01).contains(v)), "pixel {pixel:?}: {inside:?} in page {key:x}");
            let footprint = match level_rule {
                LevelRule::Area => dx.perp_dot(dy).abs().sqrt(),
                LevelRule::MinLength => dx.length().min(dy.length()),
            };
            // the level is rounded down: the footprint has one to two texels
            let ratio = footprint * f64::from(level_bias).exp2() / (side / texels);
            checked += 1;
            wrong += usize::from(!(0.97..2.06).contains(&ratio));
        }
        assert!(checked > 10_000 && wrong * 100 < checked, "{level_rule:?} {level_bias}: {wrong} of {checked} pixels");
    }
}
