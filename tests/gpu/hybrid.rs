//! A map with exact edges against ray tracing and against the engine's own rays.

use crate::bench::Bench;
use crate::comparators::mixed;
use crate::scenes;
use glam::{DVec3, Vec3};
use umbrage::Light;
use umbrage::lab::{Lab, View};
use umbrage::methods::{Method, MethodSpec, create};
use umbrage::scene::{Changes, Scene};
use umbrage::truth::{Metrics, compare};

const SIZE: [u32; 2] = [320, 180];

fn method(lab: &Lab, spec: &str) -> Box<dyn Method> {
    create(&MethodSpec::parse(spec).unwrap(), lab).unwrap()
}

/// Errors of a frame and its rays, where it has any.
fn draw(lab: &Lab, method: &mut dyn Method) -> (Metrics, Option<u64>) {
    method.frame(lab).unwrap();
    let visibility = method.visibility(lab, 0).unwrap();
    mixed(&visibility).unwrap();
    let counters = method.statistics(lab).unwrap().counters;
    let rays = counters.iter().find(|(name, _)| *name == "rays").map(|(_, rays)| *rays);
    (compare(&visibility, &lab.reference(0, &|_| {}).unwrap()).unwrap(), rays)
}

/// Where casters are wider than a texel, edges are as exact as rays, at a fraction of the rays.
#[test]
fn what_the_map_saw_is_exact() {
    for ((scene, view), least) in [(scenes::sphere_on_plane(SIZE), 2.0), (scenes::closed(SIZE), 0.5)] {
        let name = scene.name.clone();
        let lab = Bench::new(scene, view);
        let (own, rays) = draw(&lab, method(&lab, "hybrid:resolution=256").as_mut());
        let (map, _) = draw(&lab, method(&lab, "uniform:resolution=256").as_mut());
        let rays = rays.expect("a count of rays");
        println!("{name}: {} %, {} % of the map, {rays} rays", own.mismatch, map.mismatch);
        assert!(own.mismatch <= 0.01 && map.mismatch > 0.02 * least, "{name}: {own:?}, {map:?}");
        assert!(rays > 100 && rays < u64::from(SIZE[0] * SIZE[1]) / 3, "{name}: {rays}");
    }
}

/// A caster thinner than a texel may lie between the texels' middles: what the map never saw no ray is sent for.
#[test]
fn thin_casters_are_lost_with_coarse_texels_only() {
    let (scene, view) = scenes::thin_poles(SIZE);
    let lab = Bench::new(scene, view);
    let errs = [64, 4096].map(|side| draw(&lab, method(&lab, &format!("hybrid:resolution={side}")).as_mut()));
    println!("{errs:?}");
    assert!(errs[0].0.mismatch > 4.0 * errs[1].0.mismatch && errs[1].0.mismatch < 0.05);
    assert!(errs[0].0.acne < 0.01, "rays do not shadow what is lit");
    let exact = draw(&lab, method(&lab, "rmsm:exact=true").as_mut()).0;
    assert!(exact.mismatch <= errs[1].0.mismatch + 0.01, "{exact:?}");
}

/// A wider neighbourhood sends more rays and misses no more.
#[test]
fn a_wider_neighbourhood_sees_more() {
    let (scene, view) = scenes::leaves(SIZE);
    let lab = Bench::new(scene, view);
    let errs = [1, 3].map(|reach| draw(&lab, method(&lab, &format!("hybrid:resolution=256,reach={reach}")).as_mut()));
    println!("{errs:?}");
    assert!(errs[1].1 > errs[0].1 && errs[1].0.mismatch <= errs[0].0.mismatch);
}

/// The tree follows casters, and the map the light.
#[test]
fn what_moves_is_seen_at_once() {
    let (scene, view) = scenes::sphere_on_plane(SIZE);
    let mut lab = Bench::new(scene, view.clone());
    let mut method = method(&lab, "hybrid:resolution=512");
    for step in 0..3 {
        let (own, _) = draw(&lab, method.as_mut());
        assert!(own.mismatch < 0.01, "step {step}: {own:?}");
        let edit = |scene: &mut Scene| {
            let i = scene.instances.len() - 1;
            let by = Vec3::new(0.3, 0.05, -0.2);
            (0..3).for_each(|axis| scene.instances[i].rows[axis][3] += by[axis]);
            Ok(Changes { instances: vec![i as u32], ..Changes::default() })
        };
        lab.edit(edit).unwrap();
    }
    lab.look(View { lights: vec![Light::directional(DVec3::new(-0.4, -1.0, 0.3))], ..view }).unwrap();
    let (own, _) = draw(&lab, method.as_mut());
    assert!(own.mismatch < 0.01, "{own:?}");
}
