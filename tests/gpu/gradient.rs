//! Gradient against its twin.

use crate::bench::{Bench, Lcg};
use crate::comparators::same_planes;
use crate::scenes;
use glam::Vec3;
use umbrage::gpu::structs::Frame;
use umbrage::lab::stages::{ScreenStage, Seen, frame_constants, prepass};
use umbrage::twin::receiver::{decode_normal, encode_normal, linear_depth, pixel_ray};
use umbrage::{Config, RequestRoute, twin};

/// Depth and normals without a scene behind them; one pixel in eight is empty. Normals point towards the eye, as the
/// prepass leaves them, or anywhere.
pub fn noise(frame: &Frame, seed: u64, towards_eye: bool) -> (Vec<f32>, Vec<u32>) {
    let mut lcg = Lcg(seed);
    let mut pixel = |i: u32| {
        let depth = if lcg.below(8) == 0 { 0.0 } else { lcg.unit().powi(4).max(1e-4) as f32 };
        let [x, y, z] = [0; 3].map(|_| lcg.between(-1.0, 1.0) as f32);
        let n = Vec3::new(x, y, z + 1e-3).normalize();
        let away = n.dot(pixel_ray(frame, [i % frame.size[0], i / frame.size[0]])) > 0.0;
        (depth, encode_normal(if towards_eye && away { -n } else { n }))
    };
    (0..frame.size[0] * frame.size[1]).map(&mut pixel).unzip()
}

fn check(lab: &Bench, stage: &ScreenStage, case: &str, frame: &Frame, depth: &[f32], normal: &[u32]) {
    let want = twin::gradient::gradient(frame, depth, normal);
    let Seen { depth: distances, planes: got } = stage.gradient(lab, frame, depth, Some(normal)).unwrap();
    for (&stored, &got) in depth.iter().zip(&distances) {
        let want = if stored > 0.0 { linear_depth(frame, stored) } else { 0.0 };
        assert!((got - want).abs() <= 1e-6 * want, "{case}: stored {stored} is {got} away, not {want}");
    }
    if depth.iter().all(|&d| d == 0.0) {
        assert!(got.iter().all(|g| *g == [0; 4]), "{case}: {got:?}");
    } else if let Err(why) = same_planes(&want, &got) {
        panic!("{case}: {why}");
    }
}

#[test]
fn planes_of_scenes_are_the_twins() {
    for (name, (scene, view)) in
        [("street", scenes::street([320, 180])), ("sphere", scenes::sphere_on_plane([160, 90]))]
    {
        let size = view.size;
        let lab = Bench::new(scene, view);
        let stage = ScreenStage::new(&lab, size, RequestRoute::Flags, 1024, 1).unwrap();
        let (depth, normal) = prepass(&lab).unwrap();
        check(&lab, &stage, name, &frame_constants(&lab, &Config::new(size)).unwrap().0, &depth, &normal);
    }
}

/// Without normals all but pixels between foreign surfaces get theirs from their neighbours' depths.
#[test]
fn normals_from_depth_are_those_of_the_surfaces() {
    for (name, (scene, view), most) in [
        ("sheet", scenes::sheet_over_floor([160, 90]), 0.003),
        ("room", scenes::room([320, 180]), 0.01),
        ("random", scenes::random([320, 180], 3), 0.015),
    ] {
        let size = view.size;
        let lab = Bench::new(scene, view);
        let stage = ScreenStage::new(&lab, size, RequestRoute::Flags, 1024, 1).unwrap();
        let (depth, normal) = prepass(&lab).unwrap();
        let frame = frame_constants(&lab, &Config::new(size)).unwrap().0;
        let given = stage.gradient(&lab, &frame, &depth, Some(&normal)).unwrap();
        let found = stage.gradient(&lab, &frame, &depth, None).unwrap();
        assert_eq!(given.depth, found.depth, "{name}");
        let apart = |(a, b): &(&[u32; 4], &[u32; 4])| decode_normal(a[0]).angle_between(decode_normal(b[0])) > 0.02;
        let surfaces = || given.planes.iter().zip(&found.planes).zip(&depth).filter(|(_, d)| **d > 0.0).map(|(p, _)| p);
        let (wrong, all) = (surfaces().filter(apart).count(), surfaces().count());
        println!("{name}: {wrong} of {all} normals are off");
        assert!(all > 1000 && (wrong as f64) < most * all as f64, "{name}: {wrong} of {all}");
        assert!(given.planes.iter().zip(&found.planes).all(|(a, b)| (a == &[0; 4]) == (b == &[0; 4])), "{name}");
    }
}

#[test]
fn planes_of_noise_are_the_twins() {
    for (seed, size) in (1..).zip([[1, 1], [7, 8], [8, 8], [9, 8], [8, 9], [63, 5], [65, 40]]) {
        let (scene, mut view) = scenes::sphere_on_plane(size);
        view.size = size;
        let lab = Bench::new(scene, view);
        let frame = frame_constants(&lab, &Config::new(size)).unwrap().0;
        let stage = ScreenStage::new(&lab, size, RequestRoute::Flags, 1024, 1).unwrap();
        let mut normal = Vec::new();
        for towards_eye in [false, true] {
            let (mut depth, made) = noise(&frame, seed, towards_eye);
            (depth[0], normal) = (0.5, made);
            check(&lab, &stage, &format!("{size:?}, seed {seed}"), &frame, &depth, &normal);
        }
        let depth = vec![0.0; normal.len()];
        check(&lab, &stage, "nothing", &frame, &depth, &normal);
    }
}
