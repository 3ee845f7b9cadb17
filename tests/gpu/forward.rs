//! Forward shadow mapping: lit interiors are 1 and shadows 0, sums against a twin that gathers, holes, lights, and equal bits.

use crate::bench::Bench;
use crate::comparators::{mixed, same_image};
use crate::scenes;
use glam::{DVec3, Vec3};
use umbrage::Light;
use umbrage::gpu::structs::ForwardSample;
use umbrage::lab::{Lab, LabError, View};
use umbrage::methods::{ForwardStage, Method, MethodSpec, check, create};
use umbrage::scene::Scene;
use umbrage::truth::{Metrics, compare};

const SIZE: [u32; 2] = [320, 180];
const HOLE: u32 = u32::MAX;

fn stage(lab: &Lab, spec: &str) -> ForwardStage {
    let mut stage = ForwardStage::new(&MethodSpec::parse(spec).unwrap(), lab).unwrap();
    stage.method().frame(lab).unwrap();
    stage
}

fn counter(lab: &Lab, method: &mut dyn Method, name: &str) -> u64 {
    let counters = method.statistics(lab).unwrap().counters;
    counters.iter().find(|(counter, _)| *counter == name).expect("the counter").1
}

/// Sun, spot and point light for the scenes around the origin.
fn lights() -> [Light; 3] {
    let at = DVec3::new(-2.0, 4.0, 1.5);
    let spot = Light::Spot { position: at, direction: -at, inner_angle_deg: 0.0, outer_angle_deg: 50.0, range: 30.0 };
    [Light::directional(DVec3::new(0.5, -1.0, -0.4)), spot, Light::Point { position: at, range: 30.0 }]
}

fn lit_by((scene, view): (Scene, View), light: Light) -> Bench {
    Bench::new(scene, View { lights: vec![light], ..view })
}

/// Where everything within a kernel's radius in the image is one plane, all lit or all shadowed.
fn interior(lab: &Lab, stage: &mut ForwardStage, kernel: f64) -> Vec<Option<u8>> {
    let (g, reference) = (lab.gbuffer().unwrap(), lab.reference(0, &|_| {}).unwrap());
    let errors = stage.method().sampling(lab, 0).unwrap().unwrap().errors;
    let [width, height] = SIZE.map(|n| n as i32);
    let normal = |i: usize| Vec3::from(g.normal[i]).as_dvec3();
    let inside = |i: usize| {
        let (x, y) = (i as i32 % width, i as i32 / width);
        let texel = errors[i].s.max(errors[i].t);
        // texels of the other axis add to the way; edges may lie beside the pixels' middles
        let reach = (1.5 * kernel * f64::from(texel)).ceil() as i32 + 2;
        // not where the map is far too coarse to tell: nor where it is not looked up
        if !reference.facing[i] || reach > 40 || x < reach || y < reach || x >= width - reach || y >= height - reach {
            return None;
        }
        let same = |j: usize| {
            let apart = normal(i).dot(g.point(j) - g.point(i)).abs();
            reference.decided[j]
                && reference.visibility[j] == reference.visibility[i]
                && normal(j).dot(normal(i)) > 0.9999
                && apart < 1e-3
        };
        let around =
            (y - reach..=y + reach).flat_map(|y| (x - reach..=x + reach).map(move |x| (y * width + x) as usize));
        around.clone().all(same).then_some(reference.visibility[i])
    };
    (0..g.hit.len()).map(inside).collect()
}

/// Away from edges by the kernel's radius light is exactly 1 and shadow exactly 0, with kernels and lights of all kinds.
#[test]
fn interiors_are_exact() {
    for (light, kernel) in lights().into_iter().zip([1.5, 1.0, 3.0]) {
        for scene in [scenes::closed(SIZE), scenes::sheet_over_floor(SIZE)] {
            let lab = lit_by(scene, light.clone());
            let mut stage = stage(&lab, &format!("forward:resolution=512,kernel={kernel}"));
            let inside = interior(&lab, &mut stage, kernel);
            let visibility = stage.method().visibility(&lab, 0).unwrap();
            let of =
                |value: u8| inside.iter().zip(&visibility).filter(move |(i, _)| **i == Some(value)).map(|(_, v)| *v);
            let (lit, shadowed) = (of(1).count(), of(0).count());
            let wrong = [0u8, 1].map(|value| of(value).filter(|v| *v != f32::from(value)).count());
            println!("{}, kernel {kernel}: {lit} lit, {shadowed} shadowed, wrong {wrong:?}", lab.scene().name);
            assert!(lit > 2000 && shadowed > 200, "{}: {lit} lit, {shadowed} shadowed", lab.scene().name);
            assert_eq!(wrong, [0, 0], "{}, kernel {kernel}: shadowed, lit", lab.scene().name);
            // a wider kernel reaches into this interior
            let mut wider = self::stage(&lab, "forward:resolution=64,kernel=4");
            let visibility = wider.method().visibility(&lab, 0).unwrap();
            assert!(inside.iter().zip(&visibility).any(|(i, v)| i.is_some_and(|i| *v != f32::from(i))));
        }
    }
}

/// The kernel along an axis, by its definition.
fn weight(away: i32, reach: u32) -> u32 {
    let d = away.unsigned_abs();
    if d >= reach {
        return 0;
    }
    let a = (reach * reach - d * d) * 255 / (reach * reach);
    a * a / 255
}

/// All texels within reach of a sample, whether or not their splats reach its pixel: least and greatest sum, since single
/// precision may decide depths at the threshold either way.
fn gather(s: &ForwardSample, depths: &[f32], side: i32, reach: u32) -> [u32; 2] {
    let span = |at: i32| {
        let low = (at - 128 - reach as i32).div_euclid(256);
        low.max(0)..(low + 2 * reach as i32 / 256 + 3).min(side)
    };
    let mut sums = [0, 0];
    for y in span(s.at_y) {
        for x in span(s.at_x) {
            let away = [256 * x + 128 - s.at_x, 256 * y + 128 - s.at_y];
            let depth = depths[(s.layer as i32 * side * side + y * side + x) as usize];
            let light = weight(away[0], reach) * weight(away[1], reach);
            if depth > 0.0 {
                let change = s.slope_x * away[0] as f32 / 256.0 + s.slope_y * away[1] as f32 / 256.0;
                let rounding = 4.0 * f32::EPSILON * depth.max(s.slope_x.abs() + s.slope_y.abs());
                let matches = |room: f32| depth - change <= s.nearest + room && depth - change >= s.farthest - room;
                sums[0] += if matches(-rounding) { light } else { 0 };
                sums[1] += if matches(rounding) { light } else { 0 };
            }
        }
    }
    sums
}

/// Splats add what a gathering twin finds, never more; less only where a surface bends away from the splat's plane.
#[test]
fn sums_are_those_of_a_twin() {
    const SIDE: u32 = 256;
    let [sun, _, point] = lights();
    let cases = [
        (scenes::sheet_over_floor(SIZE), sun.clone(), 1.5, 0.001),
        // texels match across creases, which their splats' planes do not follow
        (scenes::closed(SIZE), sun.clone(), 3.0, 0.1),
        (scenes::closed(SIZE), point, 2.0, 0.1),
        (scenes::sphere_on_plane(SIZE), sun, 1.0, 0.1),
    ];
    for (scene, light, kernel, missed) in cases {
        let lab = lit_by(scene, light);
        let stage = stage(&lab, &format!("forward:resolution={SIDE},kernel={kernel}"));
        let (samples, sums, depths) =
            (stage.samples(&lab).unwrap(), stage.sums(&lab).unwrap(), stage.depths(&lab).unwrap());
        let layers = if depths.len() == (SIDE * SIDE) as usize { 1.0f64 } else { 6.0 };
        let side = (f64::from(SIDE) / layers.sqrt()) as i32;
        let reach = (256.0 * kernel) as u32;
        let (mut seen, mut sure, mut less, mut more, mut lit, mut other) = (0, 0, 0, 0, 0, 0);
        for (s, &sum) in samples.iter().zip(&sums).filter(|(s, _)| s.layer < ForwardSample::OUTSIDE) {
            let sum = if sum == HOLE { 0 } else { sum };
            let [least, most] = gather(s, &depths, side, reach);
            seen += 1;
            sure += u32::from(least == most);
            lit += u32::from(most > 0);
            less += u32::from(sum < least);
            more += u32::from(sum > most);
            other += u32::from(sum > gather(s, &depths, side, reach - 16)[1]);
        }
        let name = &lab.scene().name;
        println!("{name}, kernel {kernel}: {seen} samples, {sure} sure, {lit} lit; {less} have less, {more} more");
        assert!(seen > 10_000 && lit > 5000 && lit < seen && f64::from(sure) > 0.99 * f64::from(seen), "{name}");
        assert_eq!(more, 0, "{name}: splats add more than there is");
        assert!(other > seen / 4, "{name}: another kernel would pass");
        assert!(f64::from(less) <= missed * f64::from(seen), "{name}: {less} of {seen} are not reached");
    }
}

/// Holes open where the light comes in flat, and there alone; they are lit if asked for.
#[test]
fn holes_are_where_light_is_edge_on() {
    let specs = ["forward:resolution=128,kernel=1,stretch=1", "forward:resolution=128,kernel=1,stretch=1,fill=true"];
    let share = |elevation: f64| {
        let (sin, cos) = elevation.to_radians().sin_cos();
        let (scene, view) = scenes::sheet_over_floor(SIZE);
        // along the sheet, which shadows a part only
        let lab = lit_by((scene, view), Light::directional(DVec3::new(0.08 * cos, -sin, cos)));
        let mut stage = stage(&lab, specs[0]);
        let holes = counter(&lab, stage.method(), "holes");
        let marked = stage.sums(&lab).unwrap().iter().filter(|sum| **sum == HOLE).count() as u64;
        assert_eq!(holes, marked, "{elevation} degrees");
        let mut filled = create(&MethodSpec::parse(specs[1]).unwrap(), &lab).unwrap();
        filled.frame(&lab).unwrap();
        assert_eq!(counter(&lab, filled.as_mut(), "holes"), holes, "{elevation} degrees");
        let lit = filled.visibility(&lab, 0).unwrap();
        let empty = stage.method().visibility(&lab, 0).unwrap();
        for (sum, (lit, empty)) in stage.sums(&lab).unwrap().iter().zip(lit.iter().zip(&empty)) {
            assert!(if *sum == HOLE { (*lit, *empty) == (1.0, 0.0) } else { lit == empty });
        }
        let facing = lab.reference(0, &|_| {}).unwrap().facing.iter().filter(|f| **f).count();
        holes as f64 / facing as f64
    };
    let shares = [70.0, 40.0, 12.0, 5.0].map(share);
    println!("share of holes: {shares:?}");
    assert!(shares[0] < 0.002 && shares[1] < 0.01, "{shares:?}");
    assert!(shares[2] > 0.03 && shares[3] > 1.2 * shares[2], "{shares:?}");
    // on a round body: where it turns away from the light
    let lab = lit_by(scenes::sphere_on_plane(SIZE), lights()[0].clone());
    let holes = stage(&lab, specs[0]).sums(&lab).unwrap();
    let (g, reference) = (lab.gbuffer().unwrap(), lab.reference(0, &|_| {}).unwrap());
    let Light::Directional { direction, .. } = &lab.view().lights[0] else { unreachable!() };
    let rate = |low: f64, high: f64| {
        let facing = |i: usize| -Vec3::from(g.normal[i]).as_dvec3().dot(direction.normalize());
        let of: Vec<_> = (0..holes.len())
            .filter(|&i| reference.decided[i] && reference.visibility[i] == 1 && (low..high).contains(&facing(i)))
            .collect();
        assert!(of.len() > 50, "{} pixels from {low} to {high}", of.len());
        of.iter().filter(|&&i| holes[i] == HOLE).count() as f64 / of.len() as f64
    };
    let (edge_on, face_on) = (rate(0.01, 0.2), rate(0.5, 1.0));
    println!("sphere: holes on {edge_on:.3} of what is edge-on, {face_on:.5} of what faces the light");
    assert!(edge_on > 0.05 && face_on < 0.1 * edge_on, "{edge_on}, {face_on}");
}

fn errs(lab: &Lab, spec: &str) -> Metrics {
    let mut method = create(&MethodSpec::parse(spec).unwrap(), lab).unwrap();
    method.frame(lab).unwrap();
    let visibility = method.visibility(lab, 0).unwrap();
    mixed(&visibility).unwrap_or_else(|why| panic!("{spec}: {why}"));
    assert_eq!(counter(lab, method.as_mut(), "outside"), 0, "{spec}");
    let m = compare(&visibility, &lab.reference(0, &|_| {}).unwrap()).unwrap();
    println!("{}, {spec}: mismatch {:.3} %, acne {:.3}, leak {:.3}", lab.scene().name, m.mismatch, m.acne, m.leak);
    m
}

/// With lights of all kinds, a cube's faces among them, images are those of ray tracing but for outlines and flat light.
#[test]
fn images_match_the_reference() {
    for light in lights() {
        for scene in [scenes::sphere_on_plane(SIZE), scenes::closed(SIZE)] {
            let lab = lit_by(scene, light.clone());
            let m = errs(&lab, "forward:resolution=2048");
            assert!(m.mismatch < 0.5 && m.off_edge < 0.2 && m.leak < 0.05, "{m:?} with {light:?}");
        }
    }
}

/// Fragments run in any order: sums are whole numbers, so two frames and two lights have equal bits.
#[test]
fn frames_are_equal_bits() {
    let (scene, mut view) = scenes::leaves(SIZE);
    view.lights = vec![view.lights[0].clone(), lights()[2].clone()];
    let lab = Bench::new(scene, view.clone());
    let spec = MethodSpec::parse("forward:resolution=512").unwrap();
    let mut method = create(&spec, &lab).unwrap();
    let mut frame = || {
        method.frame(&lab).unwrap();
        [0, 1].map(|light| method.visibility(&lab, light).unwrap())
    };
    let first = frame();
    assert_eq!(first, frame());
    mixed(&first[0]).unwrap();
    assert!(same_image(&first[0], &first[1]).is_err(), "two lights");
    // alone, each is as it was beside the other
    for (light, want) in view.lights.iter().zip(&first) {
        let lab = lit_by(scenes::leaves(SIZE), light.clone());
        let mut method = create(&spec, &lab).unwrap();
        method.frame(&lab).unwrap();
        assert_eq!(&method.visibility(&lab, 0).unwrap(), want);
    }
}

#[test]
fn bad_keys_are_refused() {
    for spec in [
        "forward:kernel=0.5",
        "forward:kernel=5",
        "forward:stretch=-1",
        "forward:fill=maybe",
        "forward:filter=pcf",
        "forward:cull=front",
        "forward:bias=second",
    ] {
        assert!(matches!(check(&MethodSpec::parse(spec).unwrap()), Err(LabError::Usage(_))), "{spec}");
    }
}
