//! Logarithmic perspective shadow maps: bent edges against the fitted map, ray tracing and finer triangles, the judge and the sampling
//! errors against what the logarithm is for.

use crate::bench::{Bench, Lcg};
use crate::comparators::same_image;
use crate::maps::{draw, method, near_truth, warped};
use crate::scenes;
use glam::DVec3;
use umbrage::Light;
use umbrage::gpu::structs::SamplingError;
use umbrage::lab::{Lab, View};
use umbrage::methods::Sampling;
use umbrage::truth::compare;

const SIZE: [u32; 2] = [320, 180];

fn differing(a: &[f32], b: &[f32]) -> usize {
    a.iter().zip(b).filter(|(a, b)| (**a - **b).abs() > 0.2).count()
}

fn sampling(lab: &Lab, spec: &str) -> Sampling {
    let mut method = method(lab, spec).unwrap();
    method.frame(lab).unwrap();
    method.sampling(lab, 0).unwrap().unwrap()
}

/// Where no warp serves the map is the fitted one, drawn by boxes and questions: depths and the coverage of centres on an edge are
/// rounded otherwise.
#[test]
fn without_a_warp_it_is_the_fitted_map() {
    for (scene, view) in [scenes::thin_poles(SIZE), scenes::leaves(SIZE), scenes::awning(SIZE)] {
        let name = scene.name.clone();
        let forward = -view.camera.view_from_world().row(2);
        let lab =
            Bench::new(scene, View { lights: vec![Light::directional(forward + DVec3::new(5e-4, 0.0, 2e-4))], ..view });
        for keys in ["", ",cull=back", ",cull=front,depth_bias=0", ",filter=pcf,taps=3", ",bias=slope", ",bias=second"]
        {
            let uniform = draw(&lab, &format!("uniform:resolution=512{keys}")).0;
            let (serves, image) = warped(&lab, &format!("logpsm:resolution=512{keys}"));
            let apart = differing(&uniform, &image);
            println!("{name}{keys}: {apart} pixels differ");
            assert!(!serves && apart * 1000 < uniform.len(), "{name}{keys}: {apart} pixels differ");
        }
    }
}

/// Triangles of all sizes, also those that pass through the warp's line and behind the eye, where that cuts them.
#[test]
fn triangles_through_the_line_match_the_reference() {
    let (scene, mut high) = scenes::huge_triangle(SIZE);
    let low = high.clone();
    high.lights = vec![Light::directional(DVec3::new(0.05, -1.0, 0.02))];
    let cases = [(scene.clone(), low), (scene, high), scenes::canopy(SIZE, 1), scenes::canopy(SIZE, 40)];
    for (scene, view) in cases {
        let name = scene.name.clone();
        let lab = Bench::new(scene, view);
        let reference = lab.reference(0, &|_| {}).unwrap();
        for keys in ["", ",line=eye", ",line=even", ",bias=slope"] {
            let spec = format!("logpsm:resolution=1024,warp=always{keys}");
            let (visibility, outside) = draw(&lab, &spec);
            near_truth(&format!("{name}, {spec}"), &visibility, &reference);
            assert_eq!(outside, 0, "{name}, {spec}");
        }
    }
}

/// Into how many triangles a sheet is cut makes no difference: edges within it leave no gap and bend none of its border. Texels are large, so
/// that each is seen.
#[test]
fn finer_triangles_make_the_same_mask() {
    for keys in ["", ",line=eye", ",cull=back"] {
        let spec = format!("logpsm:resolution=128,warp=always{keys}");
        let image = |n| {
            let (scene, view) = scenes::canopy(SIZE, n);
            let lab = Bench::new(scene, view);
            draw(&lab, &spec).0
        };
        let coarse = image(1);
        assert!(coarse.iter().filter(|v| **v == 0.0).count() * 8 > coarse.len(), "{spec}: little shadow");
        for n in [7, 90] {
            let apart = differing(&coarse, &image(n));
            println!("{spec}, {n} x {n} cells: {apart} pixels differ");
            assert!(apart * 2000 < coarse.len(), "{spec}, {n} x {n} cells: {apart} pixels differ");
        }
    }
}

/// Seeded: blocks and leaves, needles and sheets.
#[test]
fn random_triangles_match_the_reference() {
    for seed in 1..5 {
        for (scene, view) in [scenes::random(SIZE, seed), scenes::shards(SIZE, seed)] {
            let name = format!("{}, seed {seed}", scene.name);
            let lab = Bench::new(scene, view);
            let reference = lab.reference(0, &|_| {}).unwrap();
            let of = |spec: &str| compare(&draw(&lab, spec).0, &reference).unwrap();
            let [uniform, own] = ["uniform:resolution=2048", "logpsm:resolution=2048,warp=always"].map(of);
            println!(
                "{name}: mismatch {:.3}, uniform {:.3}, off_edge {:.3} %",
                own.mismatch, uniform.mismatch, own.off_edge
            );
            assert!(own.mismatch < 1.5 * uniform.mismatch + 0.05, "{name}: {own:?}, uniform {uniform:?}");
        }
    }
}

/// Light from above on flat ground with plates above it: fewer errors than any map of as many texels (book, 4.2.4).
#[test]
fn errs_less_than_warps_and_slices_on_flat_ground() {
    let (scene, view) = scenes::plates(SIZE);
    let lab = Bench::new(scene, view);
    let reference = lab.reference(0, &|_| {}).unwrap();
    let edge_error = |spec: &str| compare(&draw(&lab, spec).0, &reference).unwrap().edge_error;
    let own = edge_error("logpsm:resolution=256");
    for (spec, share) in [
        ("uniform:resolution=256", 0.4),
        ("lispsm:resolution=256", 0.9),
        ("tsm:resolution=256", 1.0),
        ("psm:resolution=256", 1.0),
        ("csm:resolution=128", 0.9),
        ("csm:resolution=128,warp=auto", 1.0),
    ] {
        let other = edge_error(spec);
        println!("{spec}: {other:.2}, logpsm {own:.2} %");
        assert!(own < share * other, "{spec}: {other} %, logpsm {own} %");
    }
}

/// Depths are compared on the receiver's plane at the middle of the texel as it lies before the logarithm: no bias is needed for the bend.
#[test]
fn a_plane_does_not_shadow_itself() {
    let (scene, view) = scenes::ground(SIZE, 60.0, 40.0);
    for gamma in [80.0f64, 45.0, 20.0] {
        let (sine, cosine) = gamma.to_radians().sin_cos();
        let sun = Light::directional(DVec3::new(0.1, -sine, -cosine));
        let lab = Bench::new(scene.clone(), View { lights: vec![sun], ..view.clone() });
        // a kernel takes the texels around for as large
        for keys in ["resolution=64,depth_bias=0", "resolution=512,filter=pcf"] {
            let (serves, image) = warped(&lab, &format!("logpsm:{keys},warp=always"));
            let dark = image.iter().filter(|v| **v < 1.0).count();
            assert!(serves && dark == 0, "{gamma} degrees, {keys}: {dark} pixels are dark");
        }
    }
}

/// Both sides of a texel look alike from the feet to the horizon (book, 4.33, 4.34); those of a perspective warp do not along the view.
#[test]
fn texels_look_alike_at_all_depths() {
    let (scene, view) = scenes::ground([256; 2], 60.0, 40.0);
    let lab = Bench::new(scene, view);
    let spread = |spec: &str| {
        let got = sampling(&lab, spec);
        let column: Vec<&SamplingError> =
            (0..256).map(|row| &got.errors[row * 256 + 128]).filter(|e| e.part != SamplingError::NO_PART).collect();
        assert!(column.len() > 80, "{spec}: {} pixels", column.len());
        let of = |value: fn(&SamplingError) -> f32| {
            let values = || column.iter().map(|e| value(e));
            f64::from(values().fold(0.0, f32::max) / values().fold(f32::MAX, f32::min))
        };
        [of(|e| e.perspective_s), of(|e| e.perspective_t)]
    };
    let [s, t] = spread("logpsm:resolution=512,warp=always");
    println!("greatest side over least, across and along: {s:.3}, {t:.3}");
    assert!(s < 1.1 && t < 1.1, "{s}, {t}");
    for spec in [
        "psm:resolution=512,warp=always",
        "lispsm:resolution=512,warp=always",
        "logpsm:resolution=512,warp=always,line=even",
    ] {
        let [s, t] = spread(spec);
        println!("{spec}: {s:.3}, {t:.3}");
        assert!(s.max(t) > 1.5, "{spec}: {s}, {t}");
    }
}

/// The judge sees the texels that serve: with it they never look larger on the mean than without a warp, nor than with one.
#[test]
fn the_judge_takes_the_smaller_texels() {
    let mut lcg = Lcg(23);
    let mut served = [0, 0];
    for seed in 0..6 {
        let (scene, mut view) = if seed % 2 == 0 { scenes::random(SIZE, seed) } else { scenes::long_row(SIZE) };
        view.lights = vec![Light::directional(DVec3::new(lcg.between(-2.0, 2.0), -1.0, lcg.between(-2.0, 2.0)))];
        let lab = Bench::new(scene, view);
        for line in ["depth", "eye"] {
            let mean = |spec: &str| {
                let got = sampling(&lab, spec);
                let sides: Vec<f64> = got.samples().map(|e| f64::from((e.s + e.t).min(1023.0))).collect();
                sides.iter().sum::<f64>() / sides.len() as f64
            };
            let own = format!("logpsm:resolution=256,line={line}");
            let [fitted, always, auto] = ["uniform:resolution=256", &format!("{own},warp=always"), &own].map(mean);
            let serves = warped(&lab, &own).0;
            served[usize::from(serves)] += 1;
            println!(
                "light {seed}, line={line}: fitted {fitted:.3}, warped {always:.3}, judged {auto:.3}, serves: {serves}"
            );
            // it looks at a part of the pixels
            assert!(auto < 1.1 * fitted.min(always), "light {seed}, line={line}: {fitted}, {always}, {auto}");
        }
    }
    assert!(served.iter().all(|count| *count > 0), "{served:?}");
}

/// The same frame twice gives the same bits.
#[test]
fn frames_repeat() {
    let (scene, view) = scenes::random(SIZE, 3);
    let lab = Bench::new(scene, view);
    let mut method = method(&lab, "logpsm:resolution=512,warp=always").unwrap();
    let images = [0; 3].map(|_| {
        method.frame(&lab).unwrap();
        method.visibility(&lab, 0).unwrap()
    });
    images.windows(2).for_each(|pair| same_image(&pair[0], &pair[1]).unwrap());
}

/// What bent maps do not hold.
#[test]
fn second_surfaces_are_refused() {
    let lab = Bench::plain();
    for bias in ["midpoint", "dual", "ids"] {
        let error = method(&lab, &format!("logpsm:bias={bias}")).err().expect("a refusal").to_string();
        assert!(error.contains("only unwarped maps hold") && error.contains("bias=plane"), "{bias}: {error}");
    }
}
