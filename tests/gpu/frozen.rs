//! Frozen frames: another camera looks at the pages that the last frame left.

use crate::bench::Bench;
use crate::lights::mixed_lights;
use crate::scenes;
use glam::DVec3;
use umbrage::Light;
use umbrage::lab::View;
use umbrage::methods::{self, Method, MethodSpec};

const SIZE: [u32; 2] = [96, 64];

fn visibility(lab: &Bench, method: &mut dyn Method) -> Vec<Vec<u32>> {
    let lights = 0..lab.view().lights.len();
    let bits = |values: Vec<f32>| values.into_iter().map(f32::to_bits).collect();
    lights.map(|light| bits(method.visibility(lab, light).unwrap())).collect()
}

fn counter(lab: &Bench, method: &mut dyn Method, key: &str) -> u64 {
    method.statistics(lab).unwrap().counters.iter().find(|(name, _)| *name == key).unwrap().1
}

fn moved(view: &View, by: DVec3) -> View {
    let mut view = view.clone();
    view.camera.eye += by;
    view
}

/// One sun, and lights of all kinds; bits, bytes and floats of the mask.
#[test]
fn a_frozen_frame_looks_at_the_pages_of_the_last() {
    let few = mixed_lights();
    let many = [few.clone(), few.clone()].concat();
    check(&few[..1], "rmsm");
    check(&few, "rmsm");
    check(&few, "rmsm:requests=sort,filter=pcf");
    check(&many, "rmsm:filter=poisson");
}

/// Bits and floats of the mask.
#[test]
fn a_frozen_frame_with_exact_edges_traces_again() {
    let few = mixed_lights();
    check(&few[..1], "rmsm:exact=true");
    check(&[few.clone(), few].concat(), "rmsm:exact=true");
}

fn check(lights: &[Light], spec: &str) {
    let (scene, mut view) = scenes::sphere_on_plane(SIZE);
    view.lights = lights.to_vec();
    let near = moved(&view, DVec3::new(0.3, 0.2, -0.1));
    let mut lab = Bench::new(scene, view.clone());
    let mut method = methods::create(&MethodSpec::parse(spec).unwrap(), &lab).unwrap();
    let method = method.as_mut();
    assert!(method.frozen_frame(&lab).is_err(), "{spec}: before the first frame");
    for _ in 0..8 {
        method.frame(&lab).unwrap();
    }
    assert_eq!(counter(&lab, method, "pages_deferred"), 0, "{spec}");
    let shown = visibility(&lab, method);

    // its own camera sees the same
    let times = method.frozen_frame(&lab).unwrap().unwrap();
    assert!(times.stages.iter().any(|(name, _)| *name == "lookup"), "{spec}: {times:?}");
    assert!(visibility(&lab, method) == shown, "{spec}: not the frame that was frozen");

    // another one sees nearly what its own frame shows, from the same pages
    lab.look(near.clone()).unwrap();
    method.frozen_frame(&lab).unwrap();
    let frozen = visibility(&lab, method);
    assert!(frozen != shown, "{spec}: the camera did not move");
    method.frame(&lab).unwrap();
    assert!(counter(&lab, method, "pages_drawn") > 0, "{spec}: the frozen frame had drawn its pages");
    for _ in 0..8 {
        method.frame(&lab).unwrap();
    }
    let thawed = visibility(&lab, method);
    let pixels = frozen.iter().flatten().zip(thawed.iter().flatten());
    let differing = pixels.filter(|(a, b)| (f32::from_bits(**a) - f32::from_bits(**b)).abs() > 0.3).count();
    let share = differing as f64 / frozen.iter().flatten().count() as f64;
    assert!(share < 0.02, "{spec}: {share} of the pixels differ");

    // and it left no trace
    lab.look(view).unwrap();
    for _ in 0..8 {
        method.frame(&lab).unwrap();
    }
    assert!(visibility(&lab, method) == shown, "{spec}: the frozen frame left a trace");
}

#[test]
fn methods_without_pages_have_no_frozen_frames() {
    let (scene, view) = scenes::sphere_on_plane(SIZE);
    let lab = Bench::new(scene, view);
    for name in ["uniform:resolution=256", "csm:resolution=256", "raytraced"] {
        let mut method = methods::create(&MethodSpec::parse(name).unwrap(), &lab).unwrap();
        assert!(method.frozen_frame(&lab).unwrap().is_none(), "{name}");
        assert!(!method.update_pages(&lab).unwrap(), "{name}");
    }
}
