//! Antialiased exact edges: the share of samples of each pixel that the light reaches, against rays from the same samples.

use crate::bench::Bench;
use crate::lights::{mixed_lights, point, spot};
use crate::scenes;
use umbrage::lab::View;
use umbrage::lab::stages::EngineStage;
use umbrage::scene::Scene;
use umbrage::truth::{CoverageError, compare_coverage, reference_coverage};
use umbrage::{Config, Error, Filter, Light};

const SIZE: [u32; 2] = [192, 108];

fn config(lights: usize, samples: u32) -> Config {
    let pages_per_frame = 4096;
    Config { exact: true, samples, lights: lights as u32, pages_per_frame, ..Config::new(SIZE) }
}

/// Shares of all lights of the view, and the number of rays.
fn shares(lab: &Bench, config: &Config) -> (Vec<Vec<f32>>, u32) {
    let mut stage = EngineStage::new(lab, config).unwrap();
    let (words, _) = stage.all(lab).unwrap();
    let (pixels, bits) = ((SIZE[0] * SIZE[1]) as usize, config.mask_bits);
    let most = ((1u64 << bits) - 1) as f32;
    let of_light = |slot: u32| {
        let (layer, shift) = ((slot * bits / 32) as usize, slot * bits % 32);
        let share = |&word: &u32| match bits {
            32 => f32::from_bits(word),
            _ => (u64::from(word >> shift) & ((1 << bits) - 1)) as f32 / most,
        };
        words[layer * pixels..][..pixels].iter().map(share).collect()
    };
    ((0..config.lights).map(of_light).collect(), stage.rays(lab).unwrap())
}

fn error(lab: &Bench, light: usize, samples: u32, image: &[f32]) -> CoverageError {
    let gbuffer = lab.gbuffer().unwrap();
    let (tracer, light_of) = (lab.tracer(), &lab.view().lights[light]);
    let traced = reference_coverage(tracer, lab.scene(), &gbuffer, light_of, samples, &|_| {}).unwrap();
    compare_coverage(image, &traced, &lab.reference(light, &|_| {}).unwrap()).unwrap()
}

/// Each light's shares are those of the same samples traced; those of one sample are far from that.
fn shares_are_those_of_the_samples((scene, view): (Scene, View), lights: Vec<Light>, all_samples: &[u32]) {
    let name = scene.name.clone();
    let lab = Bench::new(scene, View { lights, ..view });
    let count = lab.view().lights.len();
    let (single, _) = shares(&lab, &config(count, 1));
    for &samples in all_samples {
        let (images, rays) = shares(&lab, &config(count, samples));
        let (bytes, _) = shares(&lab, &Config { mask_bits: 8, ..config(count, samples) });
        let mut edges = 0;
        for light in 0..count {
            let case = format!("{name}, light {light}, {samples} samples");
            let e = error(&lab, light, samples, &images[light]);
            println!(
                "{case}: mean {:.4}, edge {:.3}, worst {:.1}, {} on edges",
                e.mean, e.edge, e.worst, e.edge_pixels
            );
            // a few samples lie closer to an edge than single precision tells
            assert!(e.mean <= 0.02 && e.edge <= 0.6, "{case}: {e:?}");
            let one = error(&lab, light, samples, &single[light]);
            assert!(e.edge_pixels == 0 || one.edge >= 10.0, "{case}: {one:?} with one sample");
            let places = f64::from(samples);
            assert!(images[light].iter().all(|&share| (f64::from(share) * places).fract() == 0.0), "{case}");
            let apart = images[light].iter().zip(&bytes[light]).filter(|(a, b)| (*a - *b).abs() > 0.502 / 255.0);
            assert_eq!(apart.count(), 0, "{case}: 8 bits");
            edges += e.edge_pixels;
        }
        println!("{name}, {samples} samples: {rays} rays");
        let pixels = u64::from(SIZE[0] * SIZE[1]);
        assert!(edges > pixels / 200, "{name}: {edges} pixels on edges");
        // the map decides most of them
        assert!(u64::from(rays) < pixels * count as u64 * u64::from(samples) / 4, "{name}: {rays} rays");
    }
}

#[test]
fn shares_of_a_sun_are_those_of_the_samples() {
    for (scene, all_samples) in [
        (scenes::street(SIZE), &[4, 8, 16][..]),
        (scenes::thin_poles(SIZE), &[16]),
        (scenes::leaves(SIZE), &[4]),
        (scenes::random(SIZE, 5), &[8]),
    ] {
        let lights = scene.1.lights.clone();
        shares_are_those_of_the_samples(scene, lights, all_samples);
    }
}

#[test]
fn shares_of_lights_of_all_kinds_are_those_of_the_samples() {
    shares_are_those_of_the_samples(scenes::sphere_on_plane(SIZE), mixed_lights(), &[8]);
    // cones and ranges that end on surfaces
    let lights = vec![point([0.0, 1.5, 0.0], 2.5), spot([-0.2, 2.0, 0.3], [0.3, 0.0, 0.4], 25.0, 9.0)];
    shares_are_those_of_the_samples(scenes::room(SIZE), lights, &[16]);
}

/// Coarse pages and fine ones, and pages that a pixel's samples share or not, leave the same shares.
#[test]
fn shares_do_not_depend_on_the_pages() {
    let (scene, view) = scenes::random(SIZE, 5);
    let lab = Bench::new(scene, view);
    let plenty = config(1, 8);
    for config in [
        Config { level_bias: 1.0, ..plenty.clone() },
        Config { level_bias: -6.0, ..plenty.clone() },
        Config { page_texels: 64, atlas_bytes: 16 << 20, ..plenty.clone() },
        Config { atlas_bytes: 1 << 20, ..plenty },
    ] {
        let e = error(&lab, 0, 8, &shares(&lab, &config).0[0]);
        println!("bias {}, {} bytes: {e:?}", config.level_bias, config.atlas_bytes);
        assert!(e.mean <= 0.05 && e.edge <= 1.0, "{config:?}: {e:?}");
    }
}

/// Rays through the tree and ray queries, where the device has them, find the same but for a few that graze an edge.
#[test]
fn shares_do_not_depend_on_how_rays_are_traced() {
    for (scene, view) in [scenes::street(SIZE), scenes::leaves(SIZE), scenes::random(SIZE, 8)] {
        let name = scene.name.clone();
        let lab = Bench::new(scene, view);
        let of = |ray_query| {
            let config = Config { ray_query, ..config(1, 8) };
            let mut stage = EngineStage::new(&lab, &config).unwrap();
            assert_eq!(stage.has_tree(), !(ray_query && lab.has_ray_queries()));
            stage.all(&lab).unwrap().0
        };
        let (tree, queries) = (of(false), of(true));
        let differ = tree.iter().zip(&queries).filter(|(a, b)| a != b).count();
        println!("{name}: {differ} of {} differ", tree.len());
        assert!(differ <= 2 && tree.iter().any(|&word| word != tree[0]), "{name}: {differ}");
    }
}

/// Texels larger than pixels, the edge of a sheet's shadow on each of their sides.
#[test]
fn edges_just_beyond_a_texel_are_noticed() {
    for direction in [[0.7, -1.0, 0.1], [-0.7, -1.0, 0.1], [0.1, -1.0, 0.7], [0.1, -1.0, -0.7]] {
        let (scene, view) = scenes::sheet_over_floor(SIZE);
        let lab = Bench::new(scene, View { lights: vec![Light::directional(direction.into())], ..view });
        let e = error(&lab, 0, 4, &shares(&lab, &Config { level_bias: 2.0, ..config(1, 4) }).0[0]);
        println!("{direction:?}: {e:?}");
        assert!(e.edge_pixels > 50 && e.mean <= 0.02 && e.edge <= 0.6, "{direction:?}: {e:?}");
    }
}

/// More rays than there is room for, as no page serves most of the lights: some pixels are left to the map. Where it has no
/// page it is dark, on the edges of the others it is nearly right.
#[test]
fn rays_beyond_the_capacity_are_left_to_the_map() {
    let (scene, view) = scenes::room(SIZE);
    let count = 12;
    let lights = (0..count).map(|i| point([0.05 * f64::from(i) - 0.3, 1.5, 0.1 * f64::from(i) - 0.6], 9.0));
    let lab = Bench::new(scene, View { lights: lights.collect(), ..view });
    let plenty = config(count as usize, 4);
    let (want, few) = shares(&lab, &plenty);
    let starved = Config { page_texels: 512, atlas_bytes: 16 << 20, gutter: 2, ..plenty };
    let (got, many) = shares(&lab, &starved);
    let room = (SIZE[0] * SIZE[1]).max(16384 * 4);
    println!("{few} and {many} rays, room for {room}");
    assert!(few < room && many >= room, "{few} and {many} rays, room for {room}");
    let (mut right, mut dark, mut near) = (0, 0, 0);
    for (want, got) in want.iter().flatten().zip(got.iter().flatten()) {
        let count = if want == got {
            &mut right
        } else if *got == 0.0 {
            &mut dark
        } else {
            &mut near
        };
        *count += 1;
    }
    println!("{right} right, {dark} dark, {near} near");
    assert!(dark > 1000 && (1..right / 20).contains(&near), "{right} right, {dark} dark, {near} near");
}

#[test]
fn samples_need_rays_and_room_in_the_mask() {
    let lab = Bench::plain();
    let refused = |config: Config| match EngineStage::bare(&lab, &config) {
        Err(umbrage::lab::LabError::Engine(Error::Limit { field, .. })) => field,
        Err(other) => panic!("{other}"),
        Ok(_) => "nothing",
    };
    let size = [64, 48];
    let good = Config { size, ..config(1, 4) };
    assert_eq!(refused(good.clone()), "nothing");
    assert_eq!(refused(Config { mask_bits: 8, ..good.clone() }), "nothing");
    assert_eq!(refused(Config { mask_bits: 1, ..good.clone() }), "mask_bits");
    assert_eq!(refused(Config { exact: false, ..good.clone() }), "samples");
    for samples in [0, 2, 3, 5, 32] {
        assert_eq!(refused(Config { samples, ..good.clone() }), "samples");
    }
    let filter = Filter::Pcf { taps: 4 };
    assert_eq!(refused(Config { filter, gutter: 2, exact: false, ..good }), "samples");
}
