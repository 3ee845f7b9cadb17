//! Rectilinear texture warping: the warp against its twin, importance against the samples it is made of, the images against ray
//! tracing, and the bent edges of large triangles.

use crate::bench::{Bench, Lcg};
use crate::comparators::same_image;
use crate::maps::{draw, method, near_truth};
use crate::scenes;
use glam::{DVec3, Vec3};
use umbrage::Light;
use umbrage::gpu::structs::Fit;
use umbrage::lab::Lab;
use umbrage::lab::stages_rtw::{WarpStage, across, importance};
use umbrage::methods::MethodSpec;
use umbrage::truth::compare;
use umbrage::twin::rtw::{Axis, axis, collapse, warped};

const SIZE: [u32; 2] = [320, 180];
/// No importance function makes a difference.
const CONSTANT: &str = "analysis=forward,view=false,distance=false,normal=0";

/// Importance maps of all kinds, by name.
fn cases(cells: usize, seed: u64) -> Vec<(&'static str, Vec<f32>)> {
    let mut lcg = Lcg(seed);
    let count = cells * cells;
    let mut random = |map: fn(f64) -> f64| (0..count).map(|_| map(lcg.unit()) as f32).collect::<Vec<_>>();
    let (even, wide, sparse) =
        (random(|u| u), random(|u| (-40.0 * u).exp2()), random(|u| if u < 1e-3 { 1e3 * u } else { 0.0 }));
    let spike = (0..count).map(|i| if i == count / 3 { 7.0 } else { 0.0 }).collect();
    let corner = (0..count).map(|i| if i % cells < cells / 8 && i / cells > cells / 2 { 1.0 } else { 0.0 }).collect();
    vec![
        ("even", even),
        ("wide", wide),
        ("sparse", sparse),
        ("spike", spike),
        ("corner", corner),
        ("none", vec![0.0; count]),
    ]
}

/// From 0 to 1, never backwards, and the texels' centres are where the warp brings them from.
fn is_a_warp(axis: &Axis) -> Result<(), String> {
    let (warp, side) = (&axis.warp, axis.centres.len());
    if (warp[0], warp[warp.len() - 1]) != (0.0, 1.0) {
        return Err(format!("from {} to {}", warp[0], warp[warp.len() - 1]));
    }
    if let Some(i) = warp.windows(2).position(|w| w[1].is_nan() || w[1] < w[0]) {
        return Err(format!("cell {i} begins at {} and ends at {}", warp[i], warp[i + 1]));
    }
    // a centre is rounded, and the warp stretches that
    let steepest = warp.windows(2).map(|w| w[1] - w[0]).fold(0.0, f32::max) * (warp.len() - 1) as f32;
    let rounding = 1e-3 / side as f32 + 1.2e-7 * (2.0 + steepest);
    for (i, [centre, width]) in axis.centres.iter().enumerate() {
        let back = warped(warp, *centre);
        let want = (i as f32 + 0.5) / side as f32;
        if !(0.0..=1.0).contains(centre) || *width < 0.0 || (back - want).abs() > rounding {
            return Err(format!("texel {i}, {width} wide, has its centre at {centre}, which is at {back} in the map"));
        }
    }
    // cells that are left out at the ends belong to no texel
    let widths: f64 = axis.centres.iter().map(|c| f64::from(c[1])).sum();
    let whole = warp[1] > 0.0 && warp[warp.len() - 2] < 1.0;
    if widths > 1.001 || whole && widths < 0.999 { Err(format!("texels are {widths} wide together")) } else { Ok(()) }
}

/// The same bits without a blur; with one, its exponentials are rounded otherwise.
fn as_the_twin(got: &Axis, want: &Axis, exact: bool) -> Result<(), String> {
    let apart = |(a, b): (&f32, &f32)| (a - b).abs() > if exact { 0.0 } else { 1e-5 };
    if got.warp.len() != want.warp.len() || got.centres.len() != want.centres.len() {
        return Err("of another length".into());
    }
    match got.warp.iter().zip(&want.warp).position(apart) {
        Some(i) => Err(format!("cell {i} begins at {}, not at {}", got.warp[i], want.warp[i])),
        None if exact && got.centres != want.centres => Err("centres differ".into()),
        None => Ok(()),
    }
}

#[test]
fn warps_are_those_of_the_twin() {
    let lab = Bench::plain();
    for (cells, side, blur, seed) in [
        (64, 64, 0.0, 1),
        (64, 2048, 3.0, 2),
        (100, 333, 0.5, 3),
        (512, 4096, 3.0, 4),
        (1024, 512, 0.0, 5),
        (257, 256, 32.0, 6),
    ] {
        let stage = WarpStage::new(&lab, cells, side, blur).unwrap();
        for (name, map) in cases(stage.cells(), seed) {
            let name = format!("{name}, {cells} cells, {side} texels, blur {blur}, seed {seed}");
            let got = stage.run(&lab, &map).unwrap();
            for (got, collapsed) in got.iter().zip(collapse(&map, stage.cells())) {
                let want = axis(&collapsed, blur, side);
                is_a_warp(&want).unwrap_or_else(|why| panic!("twin, {name}: {why}"));
                is_a_warp(got).unwrap_or_else(|why| panic!("{name}: {why}"));
                as_the_twin(got, &want, blur == 0.0).unwrap_or_else(|why| panic!("{name}: {why}"));
                let mut wrong = got.clone();
                wrong.warp[cells as usize / 2] += 0.5;
                assert!(is_a_warp(&wrong).is_err() && as_the_twin(&wrong, &want, false).is_err(), "{name}");
            }
        }
        // the same importance everywhere moves nothing
        let constant = stage.run(&lab, &vec![1.0; stage.cells() * stage.cells()]).unwrap();
        for axis in &constant {
            for (k, at) in axis.warp.iter().enumerate() {
                assert_eq!(*at, k as f32 / cells as f32, "cell {k} of {cells}");
            }
        }
    }
}

/// Equation 1 at its simplest: with nothing blurred, a cell gets its share of all importance.
#[test]
fn a_cell_gets_its_share_of_importance() {
    let lab = Bench::plain();
    let stage = WarpStage::new(&lab, 64, 256, 0.0).unwrap();
    // columns 0 to 15 weigh 3, the others 1; rows alike
    let map: Vec<f32> = (0..64 * 64).map(|i| if i % 64 < 16 { 3.0 } else { 1.0 }).collect();
    let [u, v] = stage.run(&lab, &map).unwrap();
    assert!((u.warp[16] - 0.5).abs() < 1e-6 && (u.warp[40] - 0.75).abs() < 1e-6, "{:?}", u.warp);
    assert!((v.warp[16] - 0.25).abs() < 1e-6, "{:?}", v.warp);
    // the texel in the middle of the map begins where column 16 does, and is a third column wide
    assert!((u.centres[128][0] - 16.0 / 64.0 - 0.5 * u.centres[128][1]).abs() < 1e-5, "{:?}", u.centres[128]);
    assert!((u.centres[128][1] - 0.5 / 64.0 * 0.75).abs() < 1e-5, "{:?}", u.centres[128]);
}

fn counter(lab: &Lab, spec: &str, name: &str) -> u64 {
    let mut method = method(lab, spec).unwrap();
    method.frame(lab).unwrap();
    let counters = method.statistics(lab).unwrap().counters;
    counters.iter().find(|(known, _)| *known == name).unwrap_or_else(|| panic!("no counter {name}")).1
}

/// With vertices that are warped one by one the same bits; exact edges are drawn by other arithmetic, which rounds depths and the
/// coverage of centres on an edge otherwise, and tessellation rounds interpolated positions.
#[test]
fn constant_importance_is_the_unwarped_map() {
    for (scene, view) in [scenes::sphere_on_plane(SIZE), scenes::leaves(SIZE), scenes::thin_poles(SIZE)] {
        let name = scene.name.clone();
        let lab = Bench::new(scene, view);
        for keys in ["fit=scene", "fit=samples", "fit=frustum", "filter=pcf,taps=3", "bias=slope"] {
            let uniform = draw(&lab, &format!("uniform:resolution=1024,{keys}")).0;
            let constant = |rest: &str| draw(&lab, &format!("rtw:resolution=1024,{CONSTANT},{keys}{rest}")).0;
            same_image(&uniform, &constant(",subdivide=0")).unwrap_or_else(|why| panic!("{name}, {keys}: {why}"));
            for rest in ["", ",subdivide=2.5"] {
                let differing = uniform.iter().zip(constant(rest)).filter(|(a, b)| (**a - b).abs() > 0.2).count();
                println!("{name}, {keys}{rest}: {differing} pixels differ");
                assert!(differing * 1000 < uniform.len(), "{name}, {keys}{rest}: {differing} pixels differ");
            }
            let warped = draw(&lab, &format!("rtw:resolution=1024,subdivide=0,{keys}")).0;
            assert!(same_image(&uniform, &warped).is_err(), "{name}, {keys}");
        }
        let spec = format!("rtw:resolution=1024,{CONSTANT}");
        assert_eq!([counter(&lab, &spec, "effective_u"), counter(&lab, &spec, "effective_v")], [1024; 2]);
    }
}

#[test]
fn images_match_the_reference() {
    for (scene, view) in [scenes::sphere_on_plane(SIZE), scenes::thin_poles(SIZE), scenes::leaves(SIZE)] {
        let name = scene.name.clone();
        let lab = Bench::new(scene, view);
        let reference = lab.reference(0, &|_| {}).unwrap();
        for spec in [
            "rtw:resolution=1024",
            "rtw:resolution=1024,fit=scene,subdivide=2.5",
            "rtw:resolution=1024,analysis=forward,fit=frustum",
            "rtw:resolution=1024,analysis=forward,edge=0.1",
            "rtw:resolution=1024,analysis=hybrid,stride=2",
            "rtw:resolution=1024,bias=slope",
        ] {
            let (visibility, outside) = draw(&lab, spec);
            near_truth(&format!("{name}, {spec}"), &visibility, &reference);
            assert_eq!(outside, 0, "{name}, {spec}");
        }
    }
}

/// Sides are told apart by the turn of exact triangles as the rasteriser does it.
#[test]
fn sides_are_left_out_alike() {
    let (scene, view) = scenes::awning(SIZE);
    let lab = Bench::new(scene, view);
    let sides = ["cull=back", "cull=front,depth_bias=0", "bias=second"];
    let uniform = sides.map(|keys| draw(&lab, &format!("uniform:resolution=512,{keys}")).0);
    let differing = |a: &[f32], b: &[f32]| a.iter().zip(b).filter(|(a, b)| a != b).count();
    for (keys, uniform) in sides.iter().zip(&uniform) {
        for subdivide in ["exact", "0", "2.5"] {
            let rtw = draw(&lab, &format!("rtw:resolution=512,{CONSTANT},{keys},subdivide={subdivide}")).0;
            let apart = differing(uniform, &rtw);
            assert!(apart * 1000 < uniform.len(), "{keys}, {subdivide}: {apart} pixels differ");
        }
    }
    // the awning's shadow
    assert!(differing(&uniform[0], &uniform[1]) * 50 > uniform[0].len());
}

/// The same frame twice gives the same bits.
#[test]
fn frames_repeat() {
    let (scene, view) = scenes::random(SIZE, 3);
    let lab = Bench::new(scene, view);
    for spec in ["rtw:resolution=512", "rtw:resolution=512,analysis=hybrid,subdivide=2.5"] {
        let mut method = method(&lab, spec).unwrap();
        let images = [0; 3].map(|_| {
            method.frame(&lab).unwrap();
            method.visibility(&lab, 0).unwrap()
        });
        images.windows(2).for_each(|pair| same_image(&pair[0], &pair[1]).unwrap());
    }
}

/// The paper's figure 7: straight edges between warped corners are wrong. Where the warp changes little along a part of a split
/// triangle splitting mends it; exact edges are right whatever the warp.
#[test]
fn a_huge_triangle_needs_bent_edges() {
    let (scene, near) = scenes::huge_triangle(SIZE);
    let mut far = near.clone();
    (far.camera.eye, far.camera.target) = (DVec3::new(6.0, 30.0, 45.0), DVec3::new(0.0, 0.0, 5.0));
    far.lights = vec![Light::directional(DVec3::new(1.0, -0.35, 0.4))];
    for (view, mending) in [(near, &["exact"][..]), (far, &["exact", "2.5"])] {
        let lab = Bench::new(scene.clone(), view);
        let reference = lab.reference(0, &|_| {}).unwrap();
        let image = |subdivide: &str| {
            let (visibility, outside) = draw(&lab, &format!("rtw:resolution=1024,fit=scene,subdivide={subdivide}"));
            let m = compare(&visibility, &reference).unwrap();
            println!("subdivide={subdivide}: mismatch {:.3}, off_edge {:.3} %", m.mismatch, m.off_edge);
            assert_eq!(outside, 0, "subdivide={subdivide}");
            (m, visibility)
        };
        let off = image("0").0;
        assert!(off.off_edge > 1.0, "without bent edges: {off:?}");
        for subdivide in mending {
            let (m, visibility) = image(subdivide);
            assert!(m.mismatch < 0.1 * off.mismatch, "subdivide={subdivide}: {m:?}, without: {off:?}");
            if *subdivide == "exact" {
                near_truth("exact edges", &visibility, &reference);
            }
        }
    }
}

/// Larger texels where little is seen make smaller ones where much is: fewer errors than a map of equal size.
#[test]
fn importance_pays_on_a_long_scene() {
    let (scene, view) = scenes::long_row(SIZE);
    let lab = Bench::new(scene, view);
    let reference = lab.reference(0, &|_| {}).unwrap();
    let mismatch = |spec: &str| compare(&draw(&lab, spec).0, &reference).unwrap().mismatch;
    let uniform = mismatch("uniform:resolution=512");
    for keys in ["analysis=backward", "analysis=forward", "analysis=hybrid", "fit=scene"] {
        let spec = format!("rtw:resolution=512,{keys}");
        let (own, finest) = (mismatch(&spec), ["effective_u", "effective_v"].map(|name| counter(&lab, &spec, name)));
        println!("{spec}: {own} %, uniform {uniform} %, as fine as {finest:?}");
        assert!(own < 0.7 * uniform, "{spec}: {own} %, uniform {uniform} %");
        assert!(finest.iter().all(|side| *side > 1024), "{spec}: {finest:?}");
    }
}

/// Which cell of a fit a pixel's sample lies in, and its importance by the paper's formulas.
fn expected(lab: &Lab, cells: usize, fit: &Fit, normal: f64, distance: bool) -> Vec<f64> {
    let (view, gbuffer) = (lab.view(), lab.gbuffer().unwrap());
    let Light::Directional { direction, .. } = &view.lights[0] else { panic!("another light") };
    let camera = &view.camera;
    let forward = (camera.target - camera.eye).normalize();
    let [x, y, _] = across(direction.normalize()).unwrap();
    let mut weights = vec![0.0f64; cells * cells];
    for i in (0..gbuffer.hit.len()).filter(|&i| gbuffer.hit[i]) {
        let [position, n] = [gbuffer.position[i], gbuffer.normal[i]].map(|v| Vec3::from(v).as_dvec3());
        if n.dot(*direction) >= 0.0 {
            continue;
        }
        let place = |row: [f32; 4]| {
            f64::from(row[0]) * position.dot(x) + f64::from(row[1]) * position.dot(y) + f64::from(row[2])
        };
        let cell = [place(fit.row_u), place(fit.row_v)].map(|at| ((at * cells as f64) as usize).min(cells - 1));
        let depth = position.dot(forward);
        // normalized device coordinates of a projection with z from -1 to 1
        let (near, far) = (camera.near, camera.far);
        let z = (far + near) / (far - near) - 2.0 * far * near / ((far - near) * depth);
        let facing = (-n.dot(position.normalize())).clamp(0.0, 1.0);
        let weight = if distance { 1.0 - z } else { 1.0 } * (1.0 + normal * facing);
        let at = cell[1] * cells + cell[0];
        weights[at] = weights[at].max(weight);
    }
    weights
}

/// Share of the cells in which two maps are alike; those with importance in at least one.
fn alike(want: &[f64], got: &[f32], within: f64) -> f64 {
    let pairs = want.iter().zip(got).filter(|(a, b)| **a > 0.0 || **b > 0.0);
    let (same, all) = pairs.fold((0, 0), |(same, all), (a, b)| {
        (same + usize::from((a - f64::from(*b)).abs() <= within * a.max(f64::from(*b))), all + 1)
    });
    f64::from(same as u32) / f64::from(all.max(1))
}

/// Sections 5.1, 5.2 and 5.4 against the formulas over the camera's samples.
#[test]
fn backward_importance_is_that_of_the_samples() {
    for (scene, view) in [scenes::sphere_on_plane(SIZE), scenes::long_row(SIZE)] {
        let name = scene.name.clone();
        let lab = Bench::new(scene, view);
        for (keys, normal, distance) in
            [("normal=0", 0.0, true), ("distance=false", 2.0, false), ("normal=5", 5.0, true)]
        {
            let spec = MethodSpec::parse(&format!("rtw:resolution=64,fit=scene,importance=64,{keys}")).unwrap();
            let (got, fit) = importance(&lab, &spec).unwrap();
            let share = alike(&expected(&lab, 64, &fit, normal, distance), &got, 2e-3);
            println!("{name}, {keys}: {:.2} % of the cells are alike", 100.0 * share);
            // single precision brings a sample at a cell's border to the other side
            assert!(share > 0.97, "{name}, {keys}: {share}");
            let other = alike(&expected(&lab, 64, &fit, normal + 1.0, !distance), &got, 2e-3);
            assert!(other < 0.5, "{name}, {keys}: {other} with other functions");
        }
    }
}

/// Forward analysis finds on a surface without casters what backward analysis finds in the samples.
#[test]
fn forward_importance_agrees_with_backward() {
    let (scene, view) = scenes::slope(SIZE, 0.3);
    let lab = Bench::new(scene, view);
    let weights = |keys: &str| {
        let spec = format!("rtw:resolution=64,fit=scene,importance=64,{keys}");
        importance(&lab, &MethodSpec::parse(&spec).unwrap()).unwrap().0
    };
    let backward: Vec<f64> = weights("analysis=backward").into_iter().map(f64::from).collect();
    // the greatest of a cell's samples is a little nearer than its middle
    let share = alike(&backward, &weights("analysis=forward"), 0.1);
    println!("{:.2} % of the cells are alike", 100.0 * share);
    assert!(share > 0.9, "{share}");
    assert!(alike(&backward, &weights("analysis=forward,normal=0"), 0.1) < 0.1);
}

/// Section 5.3: what casts an edge of a shadow keeps its importance, and all else a share of it.
#[test]
fn shadow_edges_keep_their_importance() {
    let (scene, view) = scenes::sphere_on_plane(SIZE);
    let lab = Bench::new(scene, view);
    let cells = 128;
    let weights = |edge: &str| {
        let spec = format!("rtw:resolution=64,fit=scene,importance={cells},analysis=hybrid,edge={edge}");
        importance(&lab, &MethodSpec::parse(&spec).unwrap()).unwrap()
    };
    let ((all, fit), (edges, _)) = (weights("1"), weights("0.25"));
    let kept = |i: usize| edges[i] > 0.9 * all[i];
    let seen: Vec<usize> = (0..all.len()).filter(|&i| all[i] > 0.0).collect();
    for &i in &seen {
        let ratio = edges[i] / all[i];
        assert!((ratio - 1.0).abs() < 1e-6 || (ratio - 0.25).abs() < 1e-6, "cell {i}: {ratio}");
    }
    let share = seen.iter().filter(|&&i| kept(i)).count() as f64 / seen.len() as f64;
    assert!((0.01..0.4).contains(&share), "{share} of the cells are on an edge");
    // the sphere's outline as the light sees it, a circle around its middle
    let Light::Directional { direction, .. } = &lab.view().lights[0] else { panic!("another light") };
    let [x, y, _] = across(direction.normalize()).unwrap();
    let middle = DVec3::new(0.0, 1.3, 0.0) - lab.view().camera.eye;
    let mut on_edge = [0, 0];
    for i in 0..720 {
        let (sin, cos) = (f64::from(i) * std::f64::consts::PI / 360.0).sin_cos();
        let t = [middle.dot(x) + cos, middle.dot(y) + sin];
        let place =
            |row: [f32; 4]| (f64::from(row[0]) * t[0] + f64::from(row[1]) * t[1] + f64::from(row[2])) * cells as f64;
        let at = place(fit.row_v) as usize * cells + place(fit.row_u) as usize;
        if all[at] > 0.0 {
            on_edge[usize::from(kept(at))] += 1;
        }
    }
    println!("{share:.3} of the cells are on an edge, {on_edge:?} of the outline's points");
    assert!(on_edge[1] > 100 && on_edge[1] >= 20 * on_edge[0], "{on_edge:?}");
}

/// What the camera does not see gets none of the map, and what it sees gets more of it.
#[test]
fn the_view_takes_the_map() {
    let (scene, view) = scenes::long_row(SIZE);
    let lab = Bench::new(scene, view);
    let finest = |keys: &str| counter(&lab, &format!("rtw:resolution=512,fit=scene,normal=0,{keys}"), "effective_v");
    let [all, seen, near] = ["distance=false,view=false", "distance=false", "distance=true"]
        .map(|keys| finest(&format!("analysis=forward,{keys}")));
    println!("as fine as {all}, {seen}, {near}");
    assert!(all == 512 && seen > 520 && near > 2 * seen, "{all}, {seen}, {near}");
}
