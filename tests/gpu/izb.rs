//! Irregular z-buffers: lists against a plain count of samples, casters against every pair of sample and triangle, images against
//! ray tracing.

use crate::bench::Bench;
use crate::comparators::{mixed, same_image};
use crate::lights::{point, spot};
use crate::scenes;
use glam::{DVec2, DVec3, Vec3};
use std::path::Path;
use umbrage::Light;
use umbrage::lab::{LabError, View};
use umbrage::methods::{IzbLists, Method, MethodSpec, create, izb_lists};
use umbrage::scene::{Blend, LoadOptions, load};
use umbrage::truth::{compare, compare_coverage, ray_offsets, reference_coverage};

const SIZE: [u32; 2] = [320, 180];

fn spec(text: &str) -> MethodSpec {
    MethodSpec::parse(text).unwrap()
}

fn draw(lab: &Bench, text: &str) -> (Box<dyn Method>, Vec<Vec<f32>>) {
    let mut method = create(&spec(text), lab).unwrap();
    method.frame(lab).unwrap();
    let images = (0..lab.view().lights.len()).map(|light| method.visibility(lab, light).unwrap()).collect();
    (method, images)
}

fn counter(lab: &Bench, method: &mut dyn Method, name: &str) -> u64 {
    let counters = method.statistics(lab).unwrap().counters;
    counters.iter().find(|(known, _)| *known == name).expect("a counter of this name").1
}

/// A vector as light space sees it.
fn turned(lists: &IzbLists, v: DVec3) -> DVec3 {
    DVec3::from(lists.axes.map(|axis| Vec3::from(axis).as_dvec3().dot(v)))
}

#[test]
fn lists_hold_each_sample_that_faces_the_light_once_and_where_it_lies() {
    for ((scene, view), resolution) in
        [(scenes::leaves(SIZE), 64), (scenes::low_sun(SIZE), 700), (scenes::shards(SIZE, 3), 16)]
    {
        let name = scene.name.clone();
        let lab = Bench::new(scene, view);
        let got = izb_lists(&spec(&format!("izb:resolution={resolution}")), &lab).unwrap();
        let (gbuffer, reference) = (lab.gbuffer().unwrap(), lab.reference(0, &|_| {}).unwrap());
        let mut seen = vec![0; gbuffer.hit.len()];
        let (mut elsewhere, mut unsure, mut longest) = (0, 0, 0);
        for (texel, list) in got.lists.iter().enumerate() {
            longest = longest.max(list.len());
            for &(number, place) in list {
                let pixel = number as usize;
                seen[pixel] += 1;
                let off = ray_offsets(lab.scene(), &gbuffer, pixel)[0] * Vec3::from(gbuffer.normal[pixel]).as_dvec3();
                let want = turned(&got, Vec3::from(gbuffer.position[pixel]).as_dvec3() + off);
                let place = Vec3::from(place).as_dvec3();
                let rounding = 1e-6 * (want.length() + 1.0);
                assert!(place.distance(want) < rounding, "{name}: pixel {pixel} lies at {place}, not {want}");
                let row = |row: [f32; 4]| Vec3::new(row[0], row[1], row[2]).as_dvec3().dot(want.with_z(1.0));
                let uv = f64::from(got.side) * DVec2::new(row(got.fit.row_u), row(got.fit.row_v));
                let apart = (uv - uv.round()).abs().min_element();
                let near_a_border = apart < 1e-3 * f64::from(got.side) / 64.0;
                unsure += u32::from(near_a_border);
                elsewhere +=
                    u32::from(!near_a_border && uv.floor().y as u32 * got.side + uv.floor().x as u32 != texel as u32);
            }
        }
        let mut facing = 0;
        for (pixel, &times) in seen.iter().enumerate() {
            let normal = Vec3::from(gbuffer.normal[pixel]);
            let grazing = normal.dot(got.axes[2].into()).abs() < 1e-6;
            assert!(
                grazing || times == i32::from(reference.facing[pixel]),
                "{name}: pixel {pixel} is in {times} lists"
            );
            facing += times;
        }
        println!("{name}, {resolution}: {facing} samples, longest list {longest}, {unsure} near borders");
        assert_eq!(elsewhere, 0, "{name}: samples in lists of other texels");
        assert!(facing * 4 > SIZE[0] as i32 * SIZE[1] as i32 && unsure * 4 < facing as u32, "{name}");
        let mut method = create(&spec(&format!("izb:resolution={resolution}")), &lab).unwrap();
        method.frame(&lab).unwrap();
        assert_eq!(counter(&lab, &mut *method, "samples"), facing as u64, "{name}");
        assert_eq!(counter(&lab, &mut *method, "longest_list"), longest as u64, "{name}");
        assert_eq!(counter(&lab, &mut *method, "outside"), 0, "{name}");
        // the coarsest grid makes lists longer than any fixed length would be
        assert!(resolution > 16 || longest > 128, "{name}: {longest}");
    }
}

/// What every triangle says of a sample, in double precision: 1 in shadow, 0 not, `None` where single precision may differ.
pub fn brute(triangles: &[[DVec3; 3]], sample: DVec3) -> Option<bool> {
    let mut shadowed = Some(false);
    for triangle in triangles {
        let [a, b, c] = triangle.map(|corner| corner - sample);
        let area = (b - a).truncate().perp_dot((c - a).truncate());
        // distances from the edges, inwards
        let inwards = [(a, b), (b, c), (c, a)].map(|(p, q)| {
            let edge = (q - p).truncate();
            area.signum() * p.truncate().perp_dot(q.truncate()) / edge.length().max(1e-12)
        });
        let inside = inwards.into_iter().fold(f64::INFINITY, f64::min);
        let normal = (b - a).cross(c - a);
        let slope = normal.truncate().length() / normal.z.abs();
        let rounding = 1e-6 * (1.0 + sample.length());
        let (nearer, unsure) =
            if slope < 1e6 { (-normal.dot(a) / normal.z, rounding * (1.0 + slope)) } else { (0.0, f64::INFINITY) };
        if inside > rounding && nearer > unsure {
            return Some(true);
        }
        if inside > -rounding && nearer > -unsure {
            shadowed = None;
        }
    }
    shadowed
}

#[test]
fn every_sample_inside_a_triangle_is_found() {
    let size = [160, 90];
    for seed in 1..=6 {
        let resolution = [16, 61, 256, 1024, 2048, 4096][seed as usize - 1];
        let (scene, view) = scenes::shards(size, seed);
        let lab = Bench::new(scene, view);
        let got = izb_lists(&spec(&format!("izb:resolution={resolution}")), &lab).unwrap();
        let scene = lab.scene();
        let eye = lab.gbuffer().unwrap().eye;
        let corner = |&i: &u32| turned(&got, Vec3::from(scene.positions[i as usize]).as_dvec3() - scene.origin - eye);
        let triangles: Vec<_> =
            scene.indices.chunks_exact(3).map(|t| [corner(&t[0]), corner(&t[1]), corner(&t[2])]).collect();
        let (mut counts, mut unsure) = ([0; 2], 0);
        for &(number, place) in got.lists.iter().flatten() {
            let found = got.shadowed[number as usize] & 1 == 1;
            match brute(&triangles, Vec3::from(place).as_dvec3()) {
                Some(want) => {
                    assert_eq!(found, want, "seed {seed}, {resolution}: sample {number} at {place:?}");
                    counts[usize::from(want)] += 1;
                }
                None => unsure += 1,
            }
        }
        println!("seed {seed}, {resolution}: {counts:?} lit and shadowed, {unsure} too close to tell");
        assert!(counts[0] > 500 && counts[1] > 100 && unsure * 20 < counts[0] + counts[1], "seed {seed}: {counts:?}");
    }
}

#[test]
fn images_are_those_of_ray_tracing_whatever_the_grid() {
    let all = [
        scenes::street(SIZE),
        scenes::sphere_on_plane(SIZE),
        scenes::thin_poles(SIZE),
        scenes::leaves(SIZE),
        scenes::random(SIZE, 9),
    ];
    for (scene, view) in all {
        let name = scene.name.clone();
        let lab = Bench::new(scene, view);
        let reference = lab.reference(0, &|_| {}).unwrap();
        mixed(&reference.visibility_image()).unwrap_or_else(|why| panic!("{name}: {why}"));
        let (_, images) = draw(&lab, "izb");
        let m = compare(&images[0], &reference).unwrap();
        println!("{name}: {} of {} decided pixels differ", m.differing, m.decided_pixels);
        assert!(m.decided_pixels > 20_000 && m.edge_pixels > 200, "{name}: {m:?}");
        // a few samples may lie closer to an edge than single precision tells
        assert!(m.differing <= 2 && m.lost_pixels == 0 && m.off_edge_pixels == 0, "{name}: {m:?}");
        for other in ["izb", "izb:resolution=16", "izb:resolution=4096"] {
            same_image(&images[0], &draw(&lab, other).1[0]).unwrap_or_else(|why| panic!("{name}, {other}: {why}"));
        }
        let map = compare(&draw(&lab, "uniform:resolution=1024").1[0], &reference).unwrap();
        assert!(map.differing > m.differing + 3, "{name}: {map:?} with a map");
    }
}

/// A pixel's sample on a triangle of 10 km is off it by more than rays start off surfaces; only the triangle's number tells.
#[test]
fn huge_triangles_do_not_shadow_themselves() {
    let (scene, view) = scenes::huge_ground(SIZE);
    let lab = Bench::new(scene, view);
    let reference = lab.reference(0, &|_| {}).unwrap();
    let [id, offset] = ["izb", "izb:own=offset"].map(|text| compare(&draw(&lab, text).1[0], &reference).unwrap());
    println!("{:.3} % with numbers, {:.3} % without", id.mismatch, offset.mismatch);
    assert!(id.edge_pixels > 200 && id.mismatch < 0.3 && id.acne < 0.2, "{id:?}");
    assert!(offset.acne > 5.0, "{offset:?}");
}

#[test]
fn lights_with_a_place_are_those_of_ray_tracing() {
    let lights = vec![
        point([0.1, 1.45, 0.05], 12.0),
        spot([0.0, 2.8, 0.0], [1.0, 0.0, 0.4], 40.0, 9.0),
        spot([-3.0, 2.5, 2.0], [0.0, 0.5, 0.0], 75.0, 5.0),
        Light::directional(DVec3::new(0.3, -1.0, -0.4)),
    ];
    for (scene, view) in [scenes::room(SIZE), scenes::swarm(SIZE), scenes::leaves(SIZE)] {
        let name = scene.name.clone();
        let lab = Bench::new(scene, View { lights: lights.clone(), ..view });
        let (mut method, images) = draw(&lab, "izb:resolution=300");
        assert_eq!(counter(&lab, &mut *method, "outside"), 0, "{name}");
        for (light, image) in images.iter().enumerate() {
            let m = compare(image, &lab.reference(light, &|_| {}).unwrap()).unwrap();
            println!(
                "{name}, light {light}: {} of {} differ, {} on edges",
                m.differing, m.decided_pixels, m.edge_pixels
            );
            assert!(m.differing <= 4 && m.lost_pixels == 0 && m.off_edge_pixels <= 1, "{name}, light {light}: {m:?}");
            assert!(light == 3 || m.edge_pixels > 100, "{name}, light {light}: {m:?}");
        }
    }
}

#[test]
fn shares_are_those_of_the_samples() {
    let size = [192, 108];
    let (scene, view) = scenes::leaves(size);
    let lights = vec![view.lights[0].clone(), spot([2.0, 4.0, 1.0], [0.0, 0.0, 0.0], 35.0, 12.0)];
    let lab = Bench::new(scene, View { lights, ..view });
    let gbuffer = lab.gbuffer().unwrap();
    for samples in [4, 16] {
        let text = format!("izb:resolution=128,samples={samples}");
        let (mut method, images) = draw(&lab, &text);
        assert_eq!(counter(&lab, &mut *method, "outside"), 0);
        for (light, image) in images.iter().enumerate() {
            let light_of = &lab.view().lights[light];
            let traced = reference_coverage(lab.tracer(), lab.scene(), &gbuffer, light_of, samples, &|_| {}).unwrap();
            let reference = lab.reference(light, &|_| {}).unwrap();
            let e = compare_coverage(image, &traced, &reference).unwrap();
            println!("light {light}, {samples}: mean {:.4}, edge {:.3}, {} on edges", e.mean, e.edge, e.edge_pixels);
            assert!(e.edge_pixels > 200 && e.mean <= 0.02 && e.edge <= 0.3, "light {light}, {samples}: {e:?}");
            let one = compare_coverage(&draw(&lab, "izb:resolution=128").1[light], &traced, &reference).unwrap();
            assert!(one.edge > 10.0, "light {light}, {samples}: {one:?} with one sample");
        }
        same_image(&images[0], &draw(&lab, &text).1[0]).unwrap();
    }
}

/// Leaves and sheets that let a share of the light through, over each other; pixels whose ray origins see the same share.
#[test]
fn translucent_casters_let_the_product_of_their_shares_through() {
    let lights = vec![
        Light::directional(DVec3::new(0.35, -1.0, -0.3)),
        point([0.3, 3.5, 0.4], 12.0),
        spot([1.0, 3.8, 0.5], [0.0, 0.0, 0.0], 40.0, 9.0),
    ];
    for ((mut scene, view), least) in [(scenes::leaves(SIZE), 1000), (scenes::random(SIZE, 9), 300)] {
        let name = scene.name.clone();
        scene.materials.iter_mut().filter(|m| m.alpha_cutoff > 0.0).for_each(|m| m.translucent = 1);
        let lab = Bench::new(scene, View { lights: lights.clone(), ..view });
        let (_, images) = draw(&lab, "izb");
        let gbuffer = lab.gbuffer().unwrap();
        for (light, image) in images.iter().enumerate() {
            let reference = lab.reference(light, &|_| {}).unwrap();
            let (mut shares, mut worst) = (0, 0.0f64);
            for pixel in (0..image.len()).filter(|&i| reference.decided[i]) {
                let normal = Vec3::from(gbuffer.normal[pixel]).as_dvec3();
                let (origin, point) = (lab.scene().origin, gbuffer.point(pixel));
                let (way, end) = match &lights[light] {
                    Light::Directional { direction, .. } => (-*direction, f64::INFINITY),
                    Light::Point { position, .. } | Light::Spot { position, .. } => (*position - origin - point, 1.0),
                    other => panic!("{other:?}"),
                };
                let passes = ray_offsets(lab.scene(), &gbuffer, pixel)
                    .map(|offset| lab.tracer().transmittance(point + normal * offset, way, end));
                if passes.iter().any(|share| (share - passes[0]).abs() > 1e-3) {
                    continue;
                }
                worst = worst.max((f64::from(image[pixel]) - passes[0]).abs());
                shares += u32::from(passes[0] > 0.02 && passes[0] < 0.98);
            }
            let m = compare(image, &reference).unwrap();
            println!("{name}, light {light}: {shares} shares, worst difference {worst:.5}, {} differ", m.differing);
            assert!(shares > least && worst < 1e-3, "{name}, light {light}: {shares} shares, {worst}");
            assert!(m.differing <= 2 && m.lost_pixels == 0, "{name}, light {light}: {m:?}");
            same_image(image, &draw(&lab, "izb:resolution=64").1[light]).unwrap();
        }
        let many = &draw(&lab, "izb:samples=4").1[0];
        let apart = many.iter().zip(&images[0]).map(|(a, b)| f64::from((a - b).abs())).sum::<f64>() / many.len() as f64;
        assert!(apart > 1e-4 && apart < 0.02, "{name}: {apart} between one and four samples");
    }
}

/// Panes of 30, 45 and 80 percent over a floor: each share that may pass, and no other.
#[test]
fn panes_over_each_other_multiply() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/glass/glass.gltf");
    let (_, mut view) = scenes::sphere_on_plane(SIZE);
    (view.camera.eye, view.camera.target) = (DVec3::new(0.6, 4.2, 5.2), DVec3::new(0.1, 0.2, 1.0));
    view.lights = vec![Light::directional(DVec3::new(0.15, -0.8, 0.75))];
    for (blend, want) in [
        (Blend::Translucent, &[0.0, 0.11, 0.2, 0.385, 0.55, 0.7, 1.0][..]),
        (Blend::Tested, &[0.0, 1.0]),
        (Blend::Ignored, &[0.0, 1.0]),
    ] {
        let lab = Bench::new(load(&path, &LoadOptions { blend, ..LoadOptions::default() }).unwrap(), view.clone());
        let (_, images) = draw(&lab, "izb");
        let near = |v: f32| want.iter().position(|w| (w - v).abs() < 1e-4);
        let mut seen = vec![0; want.len()];
        images[0].iter().for_each(|&v| seen[near(v).unwrap_or_else(|| panic!("{blend:?}: a share of {v}"))] += 1);
        assert!(seen.iter().all(|&n| n > 20), "{blend:?}: {seen:?} pixels of {want:?}");
        let m = compare(&images[0], &lab.reference(0, &|_| {}).unwrap()).unwrap();
        assert!(m.differing <= 2 && m.edge_pixels > 200, "{blend:?}: {m:?}");
    }
}

#[test]
fn what_a_device_cannot_hold_is_refused() {
    let (scene, view) = scenes::sphere_on_plane([2048, 1152]);
    let lab = Bench::new(scene, view);
    // 4 samples a pixel and 16 bytes each: more than the 128 MiB of a buffer that devices must have
    match create(&spec("izb:samples=4"), &lab) {
        Err(LabError::Refused(text)) => {
            assert!(text.contains("samples=4") && text.contains("150994944 bytes"), "{text}")
        }
        Err(other) => panic!("{other}"),
        // a device may have more
        Ok(_) => assert!(!lab.device_is_cpu()),
    }
}
