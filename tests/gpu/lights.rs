//! Many lights of all kinds: what their pixels ask for, who gets pages, what their shadows look like, and what is left of
//! them when they move and go.

use crate::allocate::{KEYS, PLENTY, Requests, Rig, config as small_config};
use crate::bench::{Bench, Lcg};
use crate::comparators::mixed;
use crate::request::{check, inputs};
use crate::scenes;
use glam::{DVec3, Vec3Swizzles};
use std::collections::BTreeSet;
use umbrage::gpu::structs::light_kind;
use umbrage::lab::stages::{EngineStage, Table, ViewsStage, frame_constants};
use umbrage::lab::{LabError, View};
use umbrage::scene::Scene;
use umbrage::truth::{PixelClass, classify, compare};
use umbrage::twin::allocate::Input;
use umbrage::twin::key::{from_words, key_face, key_level, key_of};
use umbrage::twin::{FACES, ROOT_LEVEL};
use umbrage::{Camera, Config, Cull, Error, LevelRule, Light, RequestRoute};

pub fn point(position: [f64; 3], range: f64) -> Light {
    Light::Point { position: position.into(), range }
}

pub fn spot(position: [f64; 3], target: [f64; 3], outer_angle_deg: f64, range: f64) -> Light {
    let (position, target) = (DVec3::from(position), DVec3::from(target));
    Light::Spot { position, direction: target - position, inner_angle_deg: 0.0, outer_angle_deg, range }
}

/// One light of each kind over the sphere on its plane.
pub fn mixed_lights() -> Vec<Light> {
    vec![
        Light::directional(DVec3::new(0.6, -1.0, -0.3)),
        point([1.5, 2.5, 1.0], 9.0),
        spot([-2.5, 3.5, 1.0], [0.0, 0.8, 0.0], 35.0, 12.0),
        spot([0.5, 3.2, 2.0], [0.2, 0.0, 0.0], 80.0, 12.0),
    ]
}

#[test]
fn pixels_ask_each_light_for_the_pages_of_their_twins() {
    let size = [192, 108];
    let (scene, mut view) = scenes::sphere_on_plane(size);
    view.lights = mixed_lights();
    let lab = Bench::new(scene, view);
    for (level_rule, level_bias) in [(LevelRule::MinLength, -3.0), (LevelRule::Area, 0.0)] {
        let config = Config { level_rule, level_bias, ..Config::new(size) };
        let shot = frame_constants(&lab, &config).unwrap();
        let kinds: Vec<u32> = shot.1.iter().map(|light| light.kind[0]).collect();
        assert_eq!(kinds, [light_kind::DIRECTIONAL, light_kind::CUBE, light_kind::SPOT, light_kind::CUBE]);
        let all = inputs(&lab, &shot, true);
        for route in [RequestRoute::Flags, RequestRoute::Sort] {
            assert_eq!(check(&lab, route, 65536, &shot, &all), 0);
        }
        check(&lab, RequestRoute::Flags, 128, &shot, &all);
    }
}

/// What the twin says of the faces, whatever the lights: those asked for and those that directional lights always have.
fn faces_asked(input: &Input) -> BTreeSet<u32> {
    let always = input.directional.iter().map(|slot| slot * FACES);
    input.requests.keys().map(|&key| key_face(key)).chain(always).collect()
}

/// Faces of the roots chosen.
fn roots_chosen(table: &Table) -> BTreeSet<u32> {
    let keys = table.pages.iter().map(|page| from_words(page.key));
    keys.filter(|&key| key_level(key) == ROOT_LEVEL).map(key_face).collect()
}

/// Roots before anything is refined: either every face has its root or nothing but roots is chosen.
fn roots_come_first(case: &str, input: &Input, table: &Table) {
    let (asked, roots) = (faces_asked(input), roots_chosen(table));
    assert!(roots.is_subset(&asked), "{case}: roots nobody asked for");
    if roots.len() < asked.len() {
        assert_eq!(table.pages.len(), roots.len(), "{case}: {} of {} roots, but finer pages", roots.len(), asked.len());
    }
    assert_eq!(table.counters.starved as usize, asked.len() - roots.len(), "{case}");
    for (&key, &entry) in table.keys.iter().zip(&table.entries).filter(|(key, _)| **key != 0) {
        assert_eq!(entry == 0, !roots.contains(&key_face(key)), "{case}: {key:x} has the entry {entry:x}");
    }
}

#[test]
fn faces_get_their_roots_before_anything_is_refined() {
    let lab = Bench::plain();
    let mut kinds = vec![light_kind::CUBE; 64];
    kinds[0] = light_kind::DIRECTIONAL;
    kinds[9] = light_kind::DIRECTIONAL;
    let mut seen = [0; 3];
    for pages in [16, 24, 64] {
        let rig = Rig::of_kinds(&lab, small_config(pages, 0.0), &kinds);
        for seed in 1..=8 {
            let mut lcg = Lcg(seed);
            let faces = 3 + lcg.below(38);
            let request = |lcg: &mut Lcg| {
                let light = lcg.below(63) + 1;
                let face = light * FACES + if kinds[light as usize] == light_kind::CUBE { lcg.below(6) } else { 0 };
                let level = 18 + lcg.below(6) as i32;
                let most = 1 << (ROOT_LEVEL - level);
                let pixels = 1 << lcg.below(16);
                (key_of(level, face, [lcg.below(most), lcg.below(most)]), 1 + lcg.below(pixels))
            };
            let requests: Requests = (0..faces).map(|_| request(&mut lcg)).collect();
            for draw_budget in [16, PLENTY] {
                let input =
                    Input { requests: requests.clone(), directional: vec![0, 9], draw_budget, ..Input::default() };
                let case = format!("seed {seed}, {pages} pages, {draw_budget} draws");
                rig.check(&case, &input);
                let table = rig.run(&input);
                roots_come_first(&case, &input, &table);
                let c = &table.counters;
                seen[0] += u32::from(c.starved > 0 && draw_budget == PLENTY);
                seen[1] += u32::from(c.starved > 0 && draw_budget < PLENTY);
                seen[2] += u32::from(c.starved == 0 && c.refused.iter().any(|&r| r > 0));
            }
        }
    }
    assert!(seen.iter().all(|&n| n > 0), "{seen:?}");
}

/// As many pixels on each of more faces than there are layers: most layers are used all the same.
#[test]
fn ties_do_not_drop_all() {
    let lab = Bench::plain();
    let requests = |faces: u32| (0..faces).map(|i| (key_of(ROOT_LEVEL, FACES * i, [0, 0]), 7)).collect::<Requests>();
    for (name, kind) in [("local", light_kind::SPOT), ("directional", light_kind::DIRECTIONAL)] {
        let rig = Rig::of_kinds(&lab, small_config(24, 0.0), &[kind; 64]);
        for faces in [24, 25, 40, KEYS] {
            let directional = if name == "local" { vec![] } else { (0..64).collect() };
            let input = Input { requests: requests(faces), directional, draw_budget: PLENTY, ..Input::default() };
            let case = format!("{faces} {name} faces");
            rig.check(&case, &input);
            let table = rig.run(&input);
            roots_come_first(&case, &input, &table);
            assert!((16..=24).contains(&table.pages.len()), "{case}: {} pages", table.pages.len());
        }
        // the same for the budget of drawing
        let rig = Rig::of_kinds(&lab, small_config(256, 0.0), &[kind; 64]);
        let directional = if name == "local" { vec![] } else { (0..64).collect() };
        let input = Input { requests: requests(KEYS), directional, draw_budget: 20, ..Input::default() };
        rig.check(name, &input);
        let table = rig.run(&input);
        roots_come_first(name, &input, &table);
        assert!((12..=20).contains(&table.pages.len()), "{name}: {} pages drawn", table.pages.len());
    }
}

const SIZE: [u32; 2] = [320, 180];

/// Everything that is asked for is drawn at once.
fn plenty(lights: usize) -> Config {
    Config { lights: lights as u32, pages_per_frame: 4096, atlas_bytes: 128 << 20, ..Config::new(SIZE) }
}

/// The layers of a mask of 32 bits, as visibilities.
fn layers(words: &[u32]) -> Vec<Vec<f32>> {
    let pixels = (SIZE[0] * SIZE[1]) as usize;
    words.chunks(pixels).map(|layer| layer.iter().map(|&word| f32::from_bits(word)).collect()).collect()
}

/// Masks of all lights of the view.
fn masks(lab: &Bench, config: &Config) -> (Vec<Vec<f32>>, Table) {
    let (words, table) = EngineStage::new(lab, config).unwrap().all(lab).unwrap();
    (layers(&words), table)
}

/// Errors of the exact frame: those of a second ray tracer.
fn exact_matches_the_reference(name: &str, lab: &Bench) {
    // in the small atlas gaps between posts may be narrower than the texels that serve them
    for (mask_bits, atlas_bytes, most_off) in [(32, 128 << 20, 0.01), (1, 2 << 20, 0.02)] {
        let lights = lab.view().lights.len();
        let config = Config { exact: true, mask_bits, atlas_bytes, ..plenty(lights) };
        let (words, _) = EngineStage::new(lab, &config).unwrap().all(lab).unwrap();
        for i in 0..lights {
            let reference = lab.reference(i, &|_| {}).unwrap();
            let m = compare(&unpack(&words, mask_bits, i as u32), &reference).unwrap();
            println!("{name}, light {i}, exact: mismatch {:.4} %, edge_error {:.3} %", m.mismatch, m.edge_error);
            let case = format!("{name}, light {i}, {mask_bits} bits: {m:?}");
            // a fraction of a percent of pixels lies closer to an edge than single precision tells
            assert!(m.mismatch <= 0.03 && m.edge_error <= 0.5 && m.off_edge <= most_off && m.lost <= 0.01, "{case}");
        }
    }
}

fn each_light_matches_the_reference((scene, mut view): (Scene, View), lights: Vec<Light>) {
    let name = scene.name.clone();
    view.lights = lights;
    let lab = Bench::new(scene, view);
    let (masks, table) = masks(&lab, &plenty(lab.view().lights.len()));
    assert_eq!((table.counters.deferred, table.counters.starved), (0, 0), "{name}: {:?}", table.counters);
    let mut edges = 0;
    for (i, mask) in masks.iter().enumerate() {
        let reference = lab.reference(i, &|_| {}).unwrap();
        let case = format!("{name}, light {i}");
        mixed(mask).unwrap_or_else(|why| panic!("{case}: {why}"));
        let m = compare(mask, &reference).unwrap();
        println!("{case}: off_edge {:.3} %, lost {:.3} %, edge_error {:.2} %", m.off_edge, m.lost, m.edge_error);
        assert!(m.decided_pixels > 2000, "{case}: {m:?}");
        assert!(m.off_edge <= 0.05 && m.lost <= 0.02 && m.edge_error <= 2.0, "{case}: {m:?}");
        // what the light does not reach is dark
        let unreached = |i: &usize| reference.hit[*i] && !reference.facing[*i];
        let wrong = (0..mask.len()).filter(unreached).filter(|&i| mask[i] > 0.5).count();
        assert!(wrong < 30, "{case}: {wrong} lit pixels that the light does not reach");
        let inverted: Vec<f32> = mask.iter().map(|v| 1.0 - v).collect();
        let m = compare(&inverted, &reference).unwrap();
        assert!(m.edge_error > 8.0 && m.off_edge > 0.25, "{case}");
        edges += usize::from(m.edge_pixels > 100);
    }
    assert!(edges + 1 >= masks.len(), "{name}: {edges} of {} lights have edges", masks.len());
    exact_matches_the_reference(&name, &lab);
}

#[test]
fn lights_over_a_sphere_match_the_reference() {
    each_light_matches_the_reference(scenes::sphere_on_plane(SIZE), mixed_lights());
}

#[test]
fn lights_among_posts_match_the_reference() {
    let lights = vec![
        point([0.0, 1.5, 0.0], 9.0),
        // casters through the plane of the light, and beside it
        spot([0.0, 1.4, 0.0], [1.0, 1.3, 0.6], 45.0, 9.0),
        spot([-3.5, 2.8, 3.0], [0.0, 0.5, 0.0], 89.0, 14.0),
        point([-0.2, 1.5, -0.2], 3.0),
    ];
    each_light_matches_the_reference(scenes::room(SIZE), lights);
}

#[test]
fn lights_at_random_match_the_reference() {
    for seed in [41, 42] {
        let mut lcg = Lcg(seed);
        let place = |lcg: &mut Lcg| [lcg.between(-3.0, 3.0), lcg.between(2.2, 4.0), lcg.between(-3.0, 3.0)];
        let lights = (0..4)
            .map(|i| {
                let (from, to) = (place(&mut lcg), place(&mut lcg));
                if i % 2 == 0 {
                    point(from, 15.0)
                } else {
                    spot(from, [to[0], 0.0, to[2]], lcg.between(30.0, 90.0), 15.0)
                }
            })
            .collect();
        each_light_matches_the_reference(scenes::random(SIZE, seed), lights);
    }
}

/// A range far beyond the scene must not push the near plane past what is close to the light.
#[test]
fn lights_of_great_range_see_what_is_close_to_them() {
    let lights = vec![
        point([-0.1, 1.6, 0.2], 1e5),
        spot([0.0, 1.75, 0.4], [-1.0, 1.75, 0.2], 50.0, 1e4),
        spot([-0.13, 1.3, -0.17], [0.0, 0.0, -0.4], 70.0, 1e6),
    ];
    each_light_matches_the_reference(scenes::room(SIZE), lights);
}

/// Pages of a light that rests become exact even while another one turns.
#[test]
fn a_light_that_rests_is_exact_while_another_turns() {
    let (scene, view) = scenes::sphere_on_plane(SIZE);
    let lab = Bench::new(scene, view);
    let config = Config { level_bias: 0.0, drift_texels: 2.0, ..plenty(2) };
    let mut kept = EngineStage::bare(&lab, &config).unwrap();
    let mut cold = EngineStage::bare(&lab, &Config { cache: false, ..config }).unwrap();
    let sun = |step: u32| Light::directional(DVec3::new(0.6 + 2e-4 * f64::from(step), -0.7, -0.3));
    let mut ids = Vec::new();
    for stage in [&mut kept, &mut cold] {
        ids = [sun(0), sun(300)].map(|light| stage.engine().add_light(&light).unwrap()).to_vec();
    }
    let mut off = 0;
    for step in 1..60 {
        for stage in [&mut kept, &mut cold] {
            stage.engine().set_light(ids[0], &sun(step)).unwrap();
            // rests from the tenth frame on
            stage.engine().set_light(ids[1], &sun(300 + step.min(10))).unwrap();
        }
        let ((a, table), (b, _)) = (kept.all(&lab).unwrap(), cold.all(&lab).unwrap());
        let turned = |slot: u32| {
            let of_light = table.pages.iter().filter(move |page| key_face(from_words(page.key)) == FACES * slot);
            of_light.filter(|page| page.turned == 1).count()
        };
        off += turned(1);
        if step > 10 + 33 {
            assert_eq!(turned(1), 0, "step {step}");
            assert!(layers(&a)[1] == layers(&b)[1], "step {step}");
            assert!(turned(0) > 0 || step % 4 > 0, "step {step}: the other light's pages are kept");
        }
    }
    assert!(off > 10, "{off} pages of the second light outlived a turn");
}

/// However few pages a frame may draw, those of many new lights are all there in the end.
#[test]
fn what_many_lights_put_off_comes() {
    let (scene, view) = scenes::random(SIZE, 9);
    let lab = Bench::new(scene, view);
    let config = Config { pages_per_frame: 16, level_bias: 1.0, ..plenty(20) };
    let mut kept = EngineStage::bare(&lab, &config).unwrap();
    let mut cold = EngineStage::bare(&lab, &Config { cache: false, pages_per_frame: 4096, ..config }).unwrap();
    let mut lcg = Lcg(12);
    let mut lights = || -> Vec<Light> {
        let place = |lcg: &mut Lcg| [lcg.between(-4.0, 4.0), lcg.between(2.0, 4.0), lcg.between(-4.0, 4.0)];
        (0..10).map(|_| point(place(&mut lcg), 6.0)).collect()
    };
    for round in 0..2 {
        let new = lights();
        for stage in [&mut kept, &mut cold] {
            new.iter().for_each(|light| assert!(stage.engine().add_light(light).is_ok()));
        }
        let want = layers(&cold.all(&lab).unwrap().0);
        let (mut starved, mut frames) = (0, 0);
        loop {
            let (words, table) = kept.all(&lab).unwrap();
            let c = &table.counters;
            assert!(c.drawn <= 16, "{c:?}");
            starved += c.starved;
            frames += 1;
            if c.starved > 0 {
                // nothing of a light that no page serves is lit
                let roots = roots_chosen(&table);
                let faces = faces_of(&table);
                let dark = |slot: u32| !(0..FACES).any(|f| roots.contains(&(FACES * slot + f)));
                for slot in (0..10 * (round + 1)).filter(|&slot| dark(slot)) {
                    let asked = (0..FACES).any(|f| faces.contains(&(FACES * slot + f)));
                    let lit = layers(&words)[slot as usize]
                        .iter()
                        .zip(&lab.gbuffer().unwrap().hit)
                        .filter(|(v, hit)| **hit && **v > 0.5)
                        .count();
                    assert!(lit == 0 || !asked, "light {slot}: {lit} pixels");
                }
            }
            if c.deferred == 0 && c.draw_threshold == 0 {
                let got = layers(&words);
                for slot in 0..10 * (round as usize + 1) {
                    assert!(got[slot] == want[slot], "light {slot}");
                }
                break;
            }
            assert!(frames < 120, "{c:?}");
        }
        println!("round {round}: {frames} frames, {starved} faces starved");
        assert!(starved > 0 && frames > 4);
    }
}

/// Which sides of casters are left out means the same for all lights.
#[test]
fn culled_sides_are_the_same_for_all_lights() {
    let (scene, mut view) = scenes::awning(SIZE);
    view.lights = vec![
        Light::directional(DVec3::new(0.1, -1.0, 0.1)),
        point([0.2, 5.0, 0.1], 20.0),
        point([-3.0, 3.2, 0.1], 20.0),
        spot([0.3, 5.0, 0.0], [0.0, 0.0, 0.0], 40.0, 20.0),
        spot([-3.0, 3.2, 0.1], [1.0, 0.0, 0.5], 80.0, 20.0),
    ];
    let lab = Bench::new(scene, view);
    let dark = |cull: Cull| -> Vec<usize> {
        let (masks, _) = masks(&lab, &Config { cull, level_bias: -1.0, ..plenty(5) });
        let lit = |mask: &Vec<f32>| mask.iter().filter(|v| **v < 0.5).count();
        masks.iter().map(lit).collect()
    };
    let [all, back, front] = [Cull::None, Cull::Back, Cull::Front].map(dark);
    // the sheet turns its front to every light
    for slot in 0..5 {
        let room = 20 + all[slot] / 100;
        assert!(all[slot].abs_diff(back[slot]) < room, "light {slot}: {all:?}, {back:?}");
        assert!(all[slot] > front[slot] + 1000, "light {slot}: {all:?}, {front:?}");
    }
}

#[test]
fn configurations_that_cannot_serve_their_lights_are_refused() {
    let (scene, view) = scenes::sphere_on_plane(SIZE);
    let lab = Bench::new(scene, view);
    let refused = |config: Config| match EngineStage::bare(&lab, &config) {
        Err(umbrage::lab::LabError::Engine(Error::Limit { field, .. })) => field,
        other => panic!("{config:?}: {}", if other.is_ok() { "taken" } else { "another error" }),
    };
    let small = Config { mask_bits: 1, ..plenty(1) };
    assert_eq!(
        refused(Config { lights: 171, page_table_bytes: Config::table_bytes(1 << 10), ..small.clone() }),
        "page_table_bytes"
    );
    assert_eq!(refused(Config { lights: 1366, ..small.clone() }), "lights");
    assert_eq!(refused(Config { lights: 0, ..small.clone() }), "lights");
    assert_eq!(refused(Config { lights: 17, route: RequestRoute::Sort, ..small.clone() }), "lights");
    assert_eq!(refused(Config { mask_bits: 16, ..small.clone() }), "mask_bits");
    let mut stage = EngineStage::bare(&lab, &small).unwrap();
    let bad = [
        point([0.0; 3], 0.0),
        point([f64::NAN, 0.0, 0.0], 1.0),
        spot([0.0; 3], [0.0; 3], 30.0, 1.0),
        spot([0.0; 3], [1.0; 3], 0.0, 1.0),
        spot([0.0; 3], [1.0; 3], 90.5, 1.0),
        Light::Area { polygon: vec![DVec3::X, DVec3::Y, DVec3::Z] },
    ];
    for light in bad {
        assert!(stage.engine().add_light(&light).is_err(), "{light:?}");
    }
    let id = stage.engine().add_light(&point([0.0; 3], 1.0)).unwrap();
    assert!(stage.engine().add_light(&point([0.0; 3], 1.0)).is_err(), "there is room for one");
    stage.engine().remove_light(id).unwrap();
    assert!(stage.engine().remove_light(id).is_err());
}

/// As many lights as there may be, most of which reach little.
#[test]
fn the_most_lights_are_served() {
    let (scene, view) = scenes::sphere_on_plane(SIZE);
    let lab = Bench::new(scene, view);
    let config =
        Config { mask_bits: 1, level_bias: 2.0, page_texels: 64, atlas_bytes: 2000 * 4 * 64 * 64, ..plenty(1365) };
    let mut stage = EngineStage::bare(&lab, &config).unwrap();
    let at = |i: u32| [0.3 * f64::from(i % 37) - 5.5, 0.3, 0.3 * f64::from(i / 37) - 5.5];
    for i in 0..1365 {
        stage.engine().add_light(&spot(at(i), [at(i)[0], 0.0, at(i)[2]], 30.0, 0.5)).unwrap();
    }
    let (words, table) = stage.all(&lab).unwrap();
    let c = &table.counters;
    assert!((c.failed, c.starved, c.deferred) == (0, 0, 0) && c.active_faces[0] > 700, "{c:?}");
    // a light is lit where its cone meets the plane and nowhere else
    let g = lab.gbuffer().unwrap();
    let origin = lab.scene().origin;
    for i in (0..1365).step_by(31) {
        let (mask, place) = (unpack(&words, 1, i), DVec3::from(at(i)));
        for pixel in (0..mask.len()).filter(|&p| g.hit[p]) {
            let q = g.point(pixel) + origin - place;
            let (inside, outside) = (q.xz().length() < 0.16 && q.y < -0.29, q.xz().length() > 0.18 || q.y > 0.0);
            assert!(!(outside && mask[pixel] > 0.5), "light {i}, pixel {pixel}: {q}");
            assert!(!(inside && mask[pixel] < 0.5 && place.xz().length() > 1.5), "light {i}, pixel {pixel}: {q}");
        }
    }
}

/// Where two faces of a point light meet, both must say the same.
#[test]
fn faces_of_a_point_light_meet_without_a_seam() {
    let (scene, mut view) = scenes::swarm(SIZE);
    let position = DVec3::new(0.03, 1.52, 0.05);
    view.lights = vec![point(position.to_array(), 9.0)];
    let lab = Bench::new(scene, view);
    let g = lab.gbuffer().unwrap();
    let origin = lab.scene().origin;
    // coarse texels make a seam wide
    for (level_bias, most) in [(-3.0, 1), (0.0, 3), (2.0, 8)] {
        let (masks, _) = masks(&lab, &Config { level_bias, ..plenty(1) });
        let reference = lab.reference(0, &|_| {}).unwrap();
        let classes = classify(&masks[0], &reference).unwrap();
        let (mut border, mut wrong, mut all, mut wrong_all) = (0, 0, 0, 0);
        for i in (0..classes.len()).filter(|&i| reference.decided[i]) {
            let mut q = (g.point(i) + origin - position).abs().to_array();
            q.sort_by(f64::total_cmp);
            let off = matches!(classes[i], PixelClass::Acne | PixelClass::Leak | PixelClass::Lost);
            all += 1;
            wrong_all += usize::from(off);
            if q[1] > 0.97 * q[2] {
                border += 1;
                wrong += usize::from(off);
            }
        }
        println!("bias {level_bias}: {wrong} of {border} on borders, {wrong_all} of {all}");
        assert!(border > 1000, "{border} pixels near a border");
        assert!(wrong <= most, "{level_bias}: {wrong} of {border}");
    }
}

/// Visibilities of slot `slot` in a mask of any kind.
fn unpack(words: &[u32], bits: u32, slot: u32) -> Vec<f32> {
    let pixels = (SIZE[0] * SIZE[1]) as usize;
    let (in_layer, most) = (32 / bits, ((1u64 << bits) - 1) as u32);
    let layer = &words[(slot / in_layer) as usize * pixels..][..pixels];
    let shift = slot % in_layer * bits;
    let value = |&word: &u32| match bits {
        32 => f32::from_bits(word),
        _ => (word >> shift & most) as f32 / most as f32,
    };
    layer.iter().map(value).collect()
}

#[test]
fn masks_of_all_widths_agree() {
    let (scene, view) = scenes::sphere_on_plane(SIZE);
    let lab = Bench::new(scene, view);
    let mut want: Option<Vec<Vec<f32>>> = None;
    let mut lcg = Lcg(3);
    let place = |lcg: &mut Lcg| [lcg.between(-3.0, 3.0), lcg.between(1.0, 4.0), lcg.between(-3.0, 3.0)];
    let lights: Vec<Light> = (0..37)
        .map(|i| match i % 3 {
            0 => point(place(&mut lcg), 4.0),
            1 => spot(place(&mut lcg), [0.0; 3], 20.0 + f64::from(i), 9.0),
            _ => Light::directional(DVec3::new(lcg.between(-1.0, 1.0), -1.0, 0.4)),
        })
        .collect();
    for bits in [32, 8, 1] {
        let config =
            Config { mask_bits: bits, level_bias: 0.0, page_table_bytes: Config::table_bytes(1 << 15), ..plenty(40) };
        let mut stage = EngineStage::bare(&lab, &config).unwrap();
        let ids: Vec<_> = lights.iter().map(|light| stage.engine().add_light(light).unwrap()).collect();
        for &i in &[1, 31, 32, 36] {
            stage.engine().remove_light(ids[i]).unwrap();
        }
        let (words, table) = stage.all(&lab).unwrap();
        assert_eq!((table.counters.deferred, table.counters.starved), (0, 0), "{:?}", table.counters);
        let used = ids.iter().enumerate().filter(|(i, _)| ![1, 31, 32, 36].contains(i));
        let got: Vec<Vec<f32>> = used.map(|(_, id)| unpack(&words, bits, id.slot())).collect();
        assert!(got.iter().filter(|layer| mixed(layer).is_ok()).count() > 20);
        match &want {
            None => want = Some(got),
            Some(want) => assert!(*want == got, "{bits} bits"),
        }
    }
}

/// Faces that the leaves of a table belong to.
fn faces_of(table: &Table) -> BTreeSet<u32> {
    table.keys.iter().filter(|key| **key != 0).map(|&key| key_face(key)).collect()
}

#[test]
fn what_no_pixel_receives_from_costs_nothing() {
    let (scene, mut view) = scenes::sphere_on_plane(SIZE);
    // sees the plane from above only
    view.camera = Camera { eye: DVec3::new(0.0, 6.0, 6.0), target: DVec3::new(0.0, 0.0, 2.0), ..view.camera };
    let lab = Bench::new(scene, view);
    let run = |lights: &[Light]| {
        let mut stage = EngineStage::bare(&lab, &plenty(lights.len().max(1))).unwrap();
        for light in lights {
            stage.engine().add_light(light).unwrap();
        }
        stage.all(&lab).unwrap()
    };
    // out of reach, below the plane, and shining up
    let unseen =
        [point([0.0, 3.0, 0.0], 0.5), point([0.0, -0.5, 0.0], 0.7), spot([0.0, 4.0, 0.0], [0.0, 9.0, 0.0], 40.0, 20.0)];
    let (words, table) = run(&unseen);
    let c = &table.counters;
    assert_eq!((c.active_faces, c.pages, c.leaves, c.nodes, c.pairs_asked), ([0; 2], 0, 0, 0, 0), "{c:?}");
    // lit only where there is no surface
    let hit = &lab.gbuffer().unwrap().hit;
    assert!(layers(&words).iter().all(|layer| layer.iter().zip(hit).all(|(&v, &hit)| v == f32::from(u8::from(!hit)))));
    let (_, none) = run(&[]);
    assert_eq!((none.counters.pages, none.counters.pairs_asked), (0, 0));
    // of a light above the plane and beside the sphere only some faces
    let (_, table) = run(&[point([2.5, 2.2, 2.0], 20.0)]);
    let c = &table.counters;
    let faces = faces_of(&table);
    assert_eq!(c.active_faces[0] as usize, faces.len(), "{c:?}");
    assert!((1..6).contains(&faces.len()) && !faces.contains(&4), "{faces:?}");
    let chosen: BTreeSet<u32> = table.pages.iter().map(|page| key_face(from_words(page.key))).collect();
    assert_eq!(chosen, faces, "pages lie on the faces that pixels see");
}

#[test]
fn a_small_light_far_away_takes_one_page() {
    let (scene, mut view) = scenes::sphere_on_plane(SIZE);
    view.camera = Camera { eye: DVec3::new(10.0, 70.0, 120.0), target: DVec3::ZERO, ..view.camera };
    let lab = Bench::new(scene, view);
    let mut stage = EngineStage::bare(&lab, &Config { level_bias: -1.0, ..plenty(8) }).unwrap();
    let lights =
        [spot([3.0, 1.0, 3.0], [3.0, 0.0, 3.0], 40.0, 2.0), spot([-3.0, 1.0, 3.0], [-3.0, 0.0, 2.5], 50.0, 2.0)];
    for (count, light) in (1..).zip(&lights) {
        stage.engine().add_light(light).unwrap();
        let counters = stage.run(&lab).unwrap();
        assert_eq!((counters.pages, counters.requested[ROOT_LEVEL as usize]), (count, count), "{counters:?}");
        assert_eq!((counters.drawn, counters.hits), (1, count - 1), "{counters:?}");
    }
}

/// Two cameras in one engine, and each in an engine of its own: of one size, of two, and where requests are made again.
#[test]
fn views_share_pages_and_see_what_they_would_alone() {
    let (scene, view) = scenes::random(SIZE, 6);
    let lab = Bench::new(scene, view);
    let base = lab.view().camera;
    let plain = Config { level_bias: -1.0, ..plenty(4) };
    let again = Config { level_bias: -7.0, page_table_bytes: Config::table_bytes(1 << 11), ..plain.clone() };
    for (sizes, config) in [
        ([SIZE, SIZE], plain.clone()),
        ([[93, 150], SIZE], plain.clone()),
        ([SIZE, [129, 41]], Config { route: RequestRoute::Sort, exact: true, samples: 4, ..plain }),
        ([[93, 150], SIZE], again),
    ] {
        let case = format!("{sizes:?}, {:?}, bias {}", config.route, config.level_bias);
        let views = [&sizes[..], &sizes[..1], &sizes[1..]];
        let mut stages: Vec<_> = views.map(|sizes| ViewsStage::new(&lab, &config, sizes).unwrap()).into();
        let mut ids = Vec::new();
        for stage in &mut stages {
            // the last reaches few tiles only
            let mut lights = mixed_lights();
            lights[3] = spot([0.5, 6.0, 2.0], [0.2, 0.0, 0.0], 12.0, 14.0);
            ids = lights.iter().map(|light| stage.engine().add_light(light).unwrap()).collect();
        }
        for step in 0..5 {
            let eye =
                |side: f64| base.eye + DVec3::new(side * (1.0 + 0.3 * f64::from(step)), 0.2 * f64::from(step), 0.0);
            let cameras = [
                Camera { eye: eye(-1.0), ..base },
                Camera { eye: eye(1.5), target: base.target + DVec3::X, fov_y_deg: 35.0, ..base },
            ];
            if step == 3 {
                for stage in &mut stages {
                    stage.engine().set_light(ids[1], &point([-1.0, 3.0, 2.0], 8.0)).unwrap();
                    stage.engine().remove_light(ids[2]).unwrap();
                }
            }
            let (both, table) = stages[0].frame(&lab, &cameras).unwrap();
            assert_eq!((table.counters.deferred, table.counters.starved), (0, 0), "{:?}", table.counters);
            let mut leaves = 0;
            for i in 0..2 {
                let (alone, own) = stages[i + 1].frame(&lab, &cameras[i..=i]).unwrap();
                assert_eq!((own.counters.deferred, own.counters.shift), (0, table.counters.shift), "{case}");
                assert_eq!(table.counters.shift > 0, config.level_bias < -1.0, "{case}: made again");
                let pixels = (sizes[i][0] * sizes[i][1]) as usize;
                assert_eq!(alone[0].len(), 4 * pixels, "{case}");
                for (slot, layer) in alone[0].chunks(pixels).enumerate().filter(|(slot, _)| step < 3 || *slot != 2) {
                    let layer: Vec<f32> = layer.iter().map(|&word| f32::from_bits(word)).collect();
                    mixed(&layer).unwrap_or_else(|why| panic!("{case}, light {slot}: {why}"));
                }
                // coarsened requests of one view may be served by finer pages of the other
                let differ = alone[0].iter().zip(&both[i]).filter(|(a, b)| a != b).count();
                let most = if own.counters.shift > 0 { pixels / 500 } else { 0 };
                assert!(differ <= most, "{case}, step {step}: {differ} words of view {i} differ");
                leaves += own.counters.leaves;
                let asked: BTreeSet<u64> = own.keys.iter().copied().filter(|key| *key != 0).collect();
                let shared: BTreeSet<u64> = table.keys.iter().copied().collect();
                assert!(asked.is_subset(&shared), "the pages of a view are those of all");
            }
            assert!(table.counters.leaves <= leaves, "pages that both ask for count once");
        }
        // a frame has an input for each view
        assert!(stages[0].frame(&lab, &[base]).is_err() || stages.is_empty());
    }
    for wrong in [[0, 180], [320, 0], [321, 180], [320, 181]] {
        let refused = ViewsStage::new(&lab, &Config { exact: false, ..plenty(1) }, &[SIZE, wrong]).map(|_| ());
        let limit = matches!(&refused, Err(LabError::Engine(Error::Limit { field: "size of a view", .. })));
        assert!(limit, "{wrong:?}: {refused:?}");
    }
}

/// A light that no layer is left for is dark everywhere, and counted.
#[test]
fn a_starved_light_is_dark() {
    let (scene, view) = scenes::sphere_on_plane(SIZE);
    let lab = Bench::new(scene, view);
    let lights = 20;
    let config = Config { page_texels: 64, atlas_bytes: 16 * 4 * 64 * 64, ..plenty(lights) };
    let mut stage = EngineStage::bare(&lab, &config).unwrap();
    for i in 0..lights {
        let x = 0.4 * i as f64 - 4.0;
        stage.engine().add_light(&spot([x, 3.0, 2.0], [x, 0.0, 1.0], 30.0, 9.0)).unwrap();
    }
    for _ in 0..3 {
        let (words, table) = stage.all(&lab).unwrap();
        let c = &table.counters;
        let served = roots_chosen(&table);
        assert!(c.starved > 0 && served.len() + c.starved as usize == faces_of(&table).len(), "{c:?}");
        for (slot, layer) in (0..).zip(layers(&words)).filter(|(slot, _)| *slot < lights as u32) {
            let lit = layer.iter().zip(&lab.gbuffer().unwrap().hit).filter(|(v, hit)| **hit && **v > 0.5).count();
            assert_eq!(lit > 0, served.contains(&(FACES * slot)), "light {slot}: {lit} lit pixels, {c:?}");
        }
    }
}
