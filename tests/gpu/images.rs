//! Images against ray tracing.

use crate::bench::Bench;
use crate::comparators::mixed;
use crate::scenes;
use umbrage::Config;
use umbrage::lab::View;
use umbrage::lab::stages::EngineStage;
use umbrage::scene::Scene;
use umbrage::truth::compare;

const SIZE: [u32; 2] = [480, 270];

fn matches_the_reference((scene, view): (Scene, View)) {
    let name = scene.name.clone();
    let lab = Bench::new(scene, view);
    let (visibility, _) =
        EngineStage::new(&lab, &Config { pages_per_frame: 4096, ..Config::new(SIZE) }).unwrap().frame(&lab).unwrap();
    let reference = lab.reference(0, &|_| {}).unwrap();
    mixed(&visibility).unwrap_or_else(|why| panic!("{name}: {why}"));
    mixed(&reference.visibility_image()).unwrap_or_else(|why| panic!("{name}, reference: {why}"));
    let m = compare(&visibility, &reference).unwrap();
    println!("{name}: off_edge {:.3} %, lost {:.3} %, edge_error {:.2} %", m.off_edge, m.lost, m.edge_error);
    let pixels = u64::from(SIZE[0] * SIZE[1]);
    assert!(m.decided_pixels * 4 > pixels && m.edge_pixels > 200, "{name}: {m:?}");
    assert!(m.off_edge <= 0.25 && m.lost <= 0.05 && m.edge_error <= 8.0, "{name}: {m:?}");
    let config = Config { pages_per_frame: 4096, exact: true, ..Config::new(SIZE) };
    let (exact, _) = EngineStage::new(&lab, &config).unwrap().frame(&lab).unwrap();
    let m = compare(&exact, &reference).unwrap();
    println!(
        "{name}, exact: mismatch {:.4} %, edge_error {:.3} %, off_edge {:.4} %",
        m.mismatch, m.edge_error, m.off_edge
    );
    assert!(m.mismatch <= 0.03 && m.edge_error <= 0.5 && m.off_edge <= 0.002, "{name}, exact: {m:?}");
    // the same comparison must fail for images that are wrong
    let inverted: Vec<f32> = visibility.iter().map(|v| 1.0 - v).collect();
    for wrong in [inverted, vec![1.0; visibility.len()], vec![0.0; visibility.len()]] {
        let m = compare(&wrong, &reference).unwrap();
        assert!(m.off_edge > 0.25 && m.edge_error > 8.0, "{name}: {m:?}");
    }
}

#[test]
fn street_view() {
    matches_the_reference(scenes::street(SIZE));
}

#[test]
fn low_sun() {
    matches_the_reference(scenes::low_sun(SIZE));
}

#[test]
fn sphere_over_a_plane() {
    matches_the_reference(scenes::sphere_on_plane(SIZE));
}

#[test]
fn thin_poles() {
    matches_the_reference(scenes::thin_poles(SIZE));
}

#[test]
fn alpha_leaves() {
    matches_the_reference(scenes::leaves(SIZE));
}
