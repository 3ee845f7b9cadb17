//! Maps that store triangles: every pixel against what the stored triangles say in double precision, tilted planes that must not
//! shadow themselves, large triangles against ray tracing, and what is lost where no texel holds an occluder.

use crate::bench::Bench;
use crate::comparators::{mixed, same_image};
use crate::izb::brute;
use crate::lights::{point, spot};
use crate::scenes;
use glam::{DVec2, DVec3, Vec3};
use std::collections::BTreeSet;
use umbrage::lab::{Lab, View};
use umbrage::methods::{MethodSpec, create, stored_triangles};
use umbrage::scene::Scene;
use umbrage::truth::{Metrics, compare, ray_offsets};

const SIZE: [u32; 2] = [320, 180];

fn spec(text: &str) -> MethodSpec {
    MethodSpec::parse(text).unwrap()
}

fn draw(lab: &Lab, text: &str, light: usize) -> Vec<f32> {
    let mut method = create(&spec(text), lab).unwrap();
    method.frame(lab).unwrap();
    method.visibility(lab, light).unwrap()
}

fn errs(lab: &Lab, text: &str, light: usize) -> Metrics {
    let m = compare(&draw(lab, text, light), &lab.reference(light, &|_| {}).unwrap()).unwrap();
    println!("{}, light {light}, {text}: {} of {} differ", lab.scene().name, m.differing, m.decided_pixels);
    m
}

/// Of an instance's triangle, relative to the scene's origin.
fn corners(scene: &Scene, instance: u32, triangle: u32) -> [DVec3; 3] {
    let row =
        |row: [f32; 4], p: DVec3| p.dot(DVec3::new(row[0].into(), row[1].into(), row[2].into())) + f64::from(row[3]);
    [0, 1, 2].map(|i| {
        let vertex = scene.indices[(3 * triangle + i) as usize];
        let p = DVec3::from(scene.positions[vertex as usize].map(f64::from));
        DVec3::from(scene.instances[instance as usize].rows.map(|r| row(r, p)))
    })
}

fn xyz(v: [f32; 4]) -> DVec3 {
    Vec3::new(v[0], v[1], v[2]).as_dvec3()
}

/// With `uncovered=lit` a pixel is dark exactly where one of the triangles around it lies over it: wrong pixels are those whose
/// occluders own none of the searched texel centres, and no others.
#[test]
fn pixels_are_what_the_stored_triangles_say() {
    let mut lost = [0; 3];
    for (neighbours, total) in lost.iter_mut().enumerate() {
        for (scene, view) in [scenes::shards(SIZE, 4), scenes::closed(SIZE), scenes::sphere_on_plane(SIZE)] {
            let lab = Bench::new(scene, view);
            let (scene, name) = (lab.scene(), &lab.scene().name);
            let text = format!("triangle_store:resolution=128,uncovered=lit,neighbours={neighbours}");
            let got = stored_triangles(&spec(&text), &lab).unwrap();
            let (gbuffer, reference) = (lab.gbuffer().unwrap(), lab.reference(0, &|_| {}).unwrap());
            let (side, reach) = (got.side as i64, neighbours as i64);
            let axes = [got.light.faces[0].x, got.light.faces[0].y, got.light.faces[0].z];
            let eye = xyz(got.light.eye);
            let turned = |p: DVec3| DVec3::from(axes.map(|axis| xyz(axis).dot(p)));
            let (mut counts, mut unsure, mut wrong, mut missed) = ([0; 2], 0, 0, 0);
            for pixel in (0..got.visibility.len()).filter(|&i| reference.facing[i]) {
                let off = ray_offsets(scene, &gbuffer, pixel)[0] * Vec3::from(gbuffer.normal[pixel]).as_dvec3();
                let from_eye = Vec3::from(gbuffer.position[pixel]).as_dvec3();
                let across = turned(from_eye) + DVec3::from(axes.map(|axis| f64::from(axis[3])));
                let t = across.with_z(1.0);
                let at = f64::from(got.side) * DVec2::new(xyz(got.fits[0].row_u).dot(t), xyz(got.fits[0].row_v).dot(t));
                if (at - at.round()).abs().min_element() < 1e-3 {
                    unsure += 1;
                    continue;
                }
                let around = (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| (x, y)));
                let held: BTreeSet<[u32; 2]> = around
                    .map(|(x, y)| {
                        let texel = [at.x as i64 + x, at.y as i64 + y].map(|v| v.clamp(0, side - 1));
                        got.triangles[(texel[1] * side + texel[0]) as usize]
                    })
                    .filter(|of| of[1] > 0)
                    .collect();
                let triangles: Vec<_> =
                    held.iter().map(|of| corners(scene, of[0], of[1] - 1).map(|p| turned(p - eye))).collect();
                let dark = got.visibility[pixel] == 0.0;
                match brute(&triangles, turned(from_eye + off)) {
                    Some(want) => {
                        assert_eq!(dark, want, "{name}, {text}: pixel {pixel} with {held:?}");
                        counts[usize::from(want)] += 1;
                    }
                    None => unsure += 1,
                }
                if reference.decided[pixel] {
                    wrong += u32::from(dark && reference.visibility[pixel] == 1);
                    missed += u32::from(!dark && reference.visibility[pixel] == 0);
                }
            }
            println!("{name}, {text}: {counts:?} lit and dark, {unsure} unsure, {wrong} wrongly dark, {missed} missed");
            assert!(counts[0] > 5000 && counts[1] > 200 && unsure * 20 < counts[0] + counts[1], "{name}: {counts:?}");
            assert_eq!(wrong, 0, "{name}, {text}: dark without an occluder");
            if *name == "shards" {
                *total = missed;
            }
        }
    }
    // the wider the search the fewer shards are lost; those smaller than a texel always are
    assert!(lost[0] > 2 * lost[1] && lost[1] > lost[2] && lost[2] > 0, "{lost:?}");
}

/// No tilt needs more than rounding: the only surface is lit wherever it faces the light, with and without its numbers.
#[test]
fn tilted_planes_do_not_shadow_themselves() {
    let mut acne = 0;
    for slope in [-3.0, 0.02, 1.7, 12.0] {
        let (scene, view) = scenes::slope(SIZE, slope);
        for lights in [view.lights.clone(), vec![spot([1.0, 9.0, 2.0], [0.0, 0.0, 0.0], 50.0, 90.0)]] {
            let lab = Bench::new(scene.clone(), View { lights, ..view.clone() });
            let reference = lab.reference(0, &|_| {}).unwrap();
            let dark = |text: &str| {
                let image = draw(&lab, text, 0);
                (0..image.len()).filter(|&i| reference.decided[i] && image[i] == 0.0).count()
            };
            let decided = reference.decided.iter().filter(|d| **d).count();
            for keys in ["resolution=64", "resolution=700,neighbours=2,uncovered=lit", "resolution=64,own=offset"] {
                assert_eq!(dark(&format!("triangle_store:{keys}")), 0, "slope {slope}, {keys}: of {decided} pixels");
            }
            acne += dark("uniform:resolution=64,bias=constant,depth_bias=0");
        }
    }
    // the same sweep would see it
    assert!(acne > 15_000, "{acne}");
}

/// Triangles larger than texels: the image of ray tracing, with a sun and with spots.
#[test]
fn large_triangles_are_exact() {
    let at = [-2.0, 4.0, 1.5];
    let lights = [None, Some(spot(at, [0.0; 3], 50.0, 30.0)), Some(spot(at, [0.0; 3], 75.0, 30.0))];
    let large = |angle| {
        let (scene, view, _) = scenes::half_plane(SIZE, angle, 0.1);
        (scene, view)
    };
    for light in lights {
        let mut differing = 0;
        for (scene, mut view) in [0.7, 2.9].map(large).into_iter().chain([scenes::awning(SIZE)]) {
            view.lights = light.clone().map_or(view.lights, |light| vec![light]);
            let lab = Bench::new(scene, view);
            let own = errs(&lab, "triangle_store:resolution=128", 0);
            // one pixel on a border differs under the wide spot
            assert!(own.differing <= u64::from(light.is_some()), "{light:?}: {own:?}");
            differing += errs(&lab, "uniform:resolution=128", 0).differing;
        }
        assert!(differing > 40, "{light:?}: {differing} differ with a map of depths");
    }
}

/// Meshes finer than the texels: what no texel around holds is found from what the sample's texel holds.
#[test]
fn walks_find_what_no_texel_holds() {
    let lab = |(scene, view)| Bench::new(scene, view);
    for lab in [lab(scenes::sphere_on_plane(SIZE)), lab(scenes::closed(SIZE))] {
        let [walk, depth, lit, map] = [
            "triangle_store:resolution=64",
            "triangle_store:resolution=64,uncovered=depth",
            "triangle_store:resolution=64,uncovered=lit",
            "uniform:resolution=64",
        ]
        .map(|text| errs(&lab, text, 0));
        assert!(walk.acne == 0.0 && walk.differing < depth.differing.min(map.differing), "{walk:?}, {depth:?}");
        assert!(lit.differing > 3 * walk.differing, "{walk:?}, {lit:?}");
    }
}

/// What is cut away is asked for where the ray meets the triangle, not at the texel's centre.
#[test]
fn alpha_is_that_of_the_point_that_is_met() {
    let (scene, view) = scenes::leaves(SIZE);
    let lights = vec![view.lights[0].clone(), point([0.5, 4.0, 0.5], 20.0)];
    let lab = Bench::new(scene, View { lights, ..view });
    for light in 0..2 {
        let reference = lab.reference(light, &|_| {}).unwrap();
        let image = draw(&lab, "triangle_store:resolution=128,uncovered=lit", light);
        let dark = |i: &usize| reference.decided[*i] && image[*i] == 0.0 && reference.visibility[*i] == 1;
        assert_eq!((0..image.len()).filter(dark).count(), 0, "light {light}: dark without an occluder");
        let [own, map] = ["triangle_store", "uniform"].map(|m| errs(&lab, &format!("{m}:resolution=256"), light));
        assert!(3 * own.differing < map.differing, "light {light}: {own:?}, {map:?}");
    }
}

#[test]
fn sides_left_out_shadow_nothing() {
    let (scene, view) = scenes::awning(SIZE);
    let lab = Bench::new(scene, view);
    let [all, back, front] =
        ["none", "back", "front"].map(|cull| draw(&lab, &format!("triangle_store:resolution=256,cull={cull}"), 0));
    mixed(&all).unwrap();
    // the sheet faces the light
    same_image(&all, &back).unwrap();
    let dark = |image: &[f32]| image.iter().filter(|v| **v == 0.0).count();
    assert!(dark(&front) + 500 < dark(&all), "{} and {}", dark(&front), dark(&all));
}
