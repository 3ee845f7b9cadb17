//! The methods that draw fitted maps, against ray tracing and against each other.

use crate::bench::Bench;
use crate::comparators::{mixed, same_image};
use crate::scenes;
use glam::DVec3;
use umbrage::Light;
use umbrage::lab::{Lab, LabError, View};
use umbrage::methods::{Method, MethodSpec, create};
use umbrage::scene::Scene;
use umbrage::truth::{Reference, compare};

const SIZE: [u32; 2] = [320, 180];
/// Most that a map may err here, in percent of edge pixels and of decided pixels.
const EDGE_ERROR: f64 = 4.0;
const OFF_EDGE: f64 = 0.1;

pub fn method(lab: &Lab, spec: &str) -> Result<Box<dyn Method>, LabError> {
    create(&MethodSpec::parse(spec).unwrap(), lab)
}

/// Visibility of one frame, and how many samples lay outside the map of their layer.
pub fn draw(lab: &Lab, spec: &str) -> (Vec<f32>, u64) {
    let mut method = method(lab, spec).unwrap();
    method.frame(lab).unwrap();
    let counters = method.statistics(lab).unwrap().counters;
    let outside = counters.iter().find(|(name, _)| *name == "outside").expect("a counter of samples outside");
    (method.visibility(lab, 0).unwrap(), outside.1)
}

/// Compares with `reference` and checks that wrong images would be seen.
pub fn near_truth(name: &str, visibility: &[f32], reference: &Reference) {
    mixed(visibility).unwrap_or_else(|why| panic!("{name}: {why}"));
    mixed(&reference.visibility_image()).unwrap_or_else(|why| panic!("{name}, reference: {why}"));
    let m = compare(visibility, reference).unwrap();
    println!("{name}: off_edge {:.3} %, lost {:.3} %, edge_error {:.2} %", m.off_edge, m.lost, m.edge_error);
    assert!(m.decided_pixels * 8 > u64::from(SIZE[0] * SIZE[1]) && m.edge_pixels > 200, "{name}: {m:?}");
    assert!(m.off_edge <= OFF_EDGE && m.lost <= 0.05 && m.edge_error <= EDGE_ERROR, "{name}: {m:?}");
    let inverted: Vec<f32> = visibility.iter().map(|v| 1.0 - v).collect();
    for wrong in [inverted, vec![1.0; visibility.len()]] {
        let m = compare(&wrong, reference).unwrap();
        assert!(m.off_edge > OFF_EDGE && m.edge_error > EDGE_ERROR, "{name}: {m:?}");
    }
}

#[test]
fn directional_maps_match_the_reference() {
    for (scene, view) in [scenes::sphere_on_plane(SIZE), scenes::thin_poles(SIZE), scenes::leaves(SIZE)] {
        let name = scene.name.clone();
        let lab = Bench::new(scene, view);
        let reference = lab.reference(0, &|_| {}).unwrap();
        for spec in [
            "uniform:resolution=2048",
            "uniform:resolution=4096,fit=scene",
            "uniform:resolution=4096,fit=frustum",
            "csm:resolution=1024",
            "csm:resolution=2048,fit=frustum",
            "lispsm:resolution=2048,warp=always",
            "lispsm:resolution=2048,warp=always,distance=1000",
            "lispsm:resolution=2048,warp=always,bias=slope",
            "tsm:resolution=2048,warp=always",
            "psm:resolution=2048",
            "logpsm:resolution=2048",
            "plane_optimal:resolution=2048",
            "plane_optimal:resolution=2048,warp=always,plane=0/1/0/0",
            "logpsm:resolution=2048,line=eye",
            "logpsm:resolution=2048,warp=always,line=even",
            "silhouette:resolution=2048",
            "triangle_store:resolution=2048",
            "csm:resolution=1024,bias=midpoint",
            "csm:resolution=4096,fit=frustum,snap=true",
            "csm:resolution=1024,warp=always,blend=0.1",
            "csm:resolution=1024,partition=faces",
            "csm:resolution=1024,partition=faces,warp=none",
            "fvsm:tile=128,tiles=256",
            "qvsm:tile=256,tiles=64",
            "tiled:tile=512",
        ] {
            let (visibility, outside) = draw(&lab, spec);
            near_truth(&format!("{name}, {spec}"), &visibility, &reference);
            assert_eq!(outside, 0, "{name}, {spec}");
        }
    }
}

#[test]
fn one_cascade_is_the_uniform_map() {
    let cases = [
        (scenes::leaves(SIZE), ""),
        (scenes::leaves(SIZE), ",depth_bias=3"),
        (scenes::sphere_on_plane(SIZE), ",cull=back"),
        (scenes::thin_poles(SIZE), ",fit=frustum"),
    ];
    for ((scene, view), keys) in cases {
        let lab = Bench::new(scene, view);
        let [uniform, csm] = ["uniform:resolution=1024", "csm:resolution=1024,cascades=1"]
            .map(|name| draw(&lab, &format!("{name}{keys}")).0);
        if keys.ends_with("frustum") {
            // split depths are rounded to single precision
            let differing = uniform.iter().zip(&csm).filter(|(a, b)| a != b).count();
            assert!(differing * 500 < uniform.len(), "{differing} pixels differ");
        } else {
            same_image(&uniform, &csm).unwrap_or_else(|why| panic!("{keys}: {why}"));
        }
        let coarser = draw(&lab, &format!("csm:resolution=512,cascades=1{keys}")).0;
        assert!(same_image(&uniform, &coarser).is_err(), "{keys}");
    }
}

#[test]
fn more_cascades_err_less_on_a_long_scene() {
    let (scene, view) = scenes::long_row(SIZE);
    let lab = Bench::new(scene, view);
    let reference = lab.reference(0, &|_| {}).unwrap();
    for fit in ["samples", "frustum"] {
        let mismatch = [1, 2, 4, 8].map(|n| {
            let (visibility, outside) = draw(&lab, &format!("csm:resolution=512,cascades={n},fit={fit}"));
            assert_eq!(outside, 0, "{n} cascades, fit={fit}");
            compare(&visibility, &reference).unwrap().mismatch
        });
        println!("fit={fit}: {mismatch:?} % differ with 1, 2, 4, 8 cascades");
        for pair in mismatch.windows(2) {
            assert!(pair[1] < 0.8 * pair[0], "fit={fit}: {mismatch:?}");
        }
    }
}

/// What keeps surfaces from shadowing themselves, on closed bodies under a high and a low sun: the second surface and the middle
/// need no number, a constant needs the right one.
#[test]
fn kinds_of_bias_on_closed_bodies() {
    let (scene, mut view) = scenes::closed(SIZE);
    for direction in [DVec3::new(0.6, -1.0, -0.3), DVec3::new(1.0, -0.25, -0.2)] {
        view.lights = vec![Light::directional(direction)];
        let lab = Bench::new(scene.clone(), view.clone());
        let reference = lab.reference(0, &|_| {}).unwrap();
        let errs = |bias: &str| {
            let m = compare(&draw(&lab, &format!("uniform:resolution=1024,bias={bias}")).0, &reference).unwrap();
            println!(
                "{bias}: mismatch {:.3}, acne {:.3}, leak {:.3}, lost {:.3} %",
                m.mismatch, m.acne, m.leak, m.lost
            );
            m
        };
        let none = errs("constant,depth_bias=0");
        assert!(none.acne > 5.0, "without bias: {none:?}");
        for bias in ["second,depth_bias=0", "midpoint,depth_bias=0", "plane", "slope"] {
            let m = errs(bias);
            assert!(m.acne < 0.02 * none.acne && m.leak < 0.3 && m.lost < 0.1, "{bias}: {m:?}");
        }
        // a triangle does not shadow itself; where the map holds its neighbour a constant must do
        let [alone, helped] = ["constant,depth_bias=1", "ids,depth_bias=1"].map(errs);
        assert!(alone.acne > 0.1 && helped.acne < 0.5 * alone.acne, "{helped:?}, a constant alone {alone:?}");
        assert!(helped.leak < alone.leak + 0.02 && helped.lost < 0.1, "{helped:?}, a constant alone {alone:?}");
        let bare = errs("ids,depth_bias=0");
        assert!(bare.acne < 0.5 * none.acne && bare.acne > helped.acne, "{bare:?}, without bias {none:?}");
        // the lesser of a constant and the middle is as the middle where the constant is large, and as the constant where it is small
        let [large, small] = ["dual,depth_bias=16", "dual,depth_bias=1"].map(errs);
        let [middle, constant] = ["midpoint", "constant,depth_bias=1"].map(errs);
        assert!((large.mismatch - middle.mismatch).abs() < 0.3 * middle.mismatch.max(0.1), "{large:?}, {middle:?}");
        assert!(small.acne >= constant.acne - 0.05 && small.leak <= constant.leak + 0.05, "{small:?}, {constant:?}");
    }
    // too much of it, and shadows leave the feet of what casts them
    let (scene, view) = scenes::thin_poles(SIZE);
    let lab = Bench::new(scene, view);
    let reference = lab.reference(0, &|_| {}).unwrap();
    let leak =
        |bias: &str| compare(&draw(&lab, &format!("uniform:resolution=1024,bias={bias}")).0, &reference).unwrap().leak;
    let (much, right) = (leak("constant,depth_bias=16"), leak("slope"));
    println!("leak {much:.3} % with 16 texels, {right:.3} with slope");
    assert!(much > right + 0.05);
}

/// Where cascades meet, visibility is a mean of both maps, and nowhere else; what is not blended stays as it is.
#[test]
fn cascades_blend_where_they_meet() {
    let (scene, view) = scenes::long_row(SIZE);
    let lab = Bench::new(scene, view);
    let reference = lab.reference(0, &|_| {}).unwrap();
    for fit in ["samples", "frustum", "frustum,snap=true"] {
        let [hard, blended, wide] = ["", ",blend=0.2", ",blend=0.5"].map(|blend| {
            let (visibility, outside) = draw(&lab, &format!("csm:resolution=96,fit={fit}{blend}"));
            assert_eq!(outside, 0, "fit={fit}{blend}");
            visibility
        });
        let between = |image: &[f32]| image.iter().filter(|v| **v > 0.0 && **v < 1.0).count();
        assert_eq!(between(&hard), 0);
        println!("fit={fit}: {} and {} pixels between", between(&blended), between(&wide));
        assert!(between(&blended) > 4 && between(&wide) > between(&blended), "fit={fit}");
        let [hard, blended] = [&hard, &blended].map(|image| compare(image, &reference).unwrap().mismatch);
        // maps that hold the end of the slice before are a little coarser
        assert!(blended < 1.6 * hard, "fit={fit}: {hard} and {blended} %");
    }
}

/// Whether the warp served, and the image.
pub fn warped(lab: &Lab, spec: &str) -> (bool, Vec<f32>) {
    let mut method = method(lab, spec).unwrap();
    method.frame(lab).unwrap();
    let counters = method.statistics(lab).unwrap().counters;
    let warped = counters.iter().find(|(name, _)| *name == "warped").expect("whether the warp serves").1;
    (warped == 1, method.visibility(lab, 0).unwrap())
}

#[test]
fn warps_err_less_on_a_long_scene() {
    let (scene, view) = scenes::long_row(SIZE);
    let lab = Bench::new(scene, view);
    let reference = lab.reference(0, &|_| {}).unwrap();
    let mismatch = |visibility: &[f32]| compare(visibility, &reference).unwrap().mismatch;
    let uniform = mismatch(&draw(&lab, "uniform:resolution=512").0);
    for name in ["lispsm", "tsm", "psm", "logpsm", "plane_optimal"] {
        let spec = &format!("{name}:resolution=512");
        let (serves, visibility) = warped(&lab, spec);
        let own = mismatch(&visibility);
        println!("{spec}: {own} %, uniform {uniform} %");
        assert!(serves && own < 0.7 * uniform, "{spec}: {own} %, uniform {uniform} %");
    }
    // a line far away is no warp
    let (serves, visibility) = warped(&lab, "lispsm:resolution=512,distance=1000000");
    assert!(!serves && visibility == draw(&lab, "uniform:resolution=512").0);
}

/// A warp for each slice: one slice is lispsm, several err less than slices alone.
#[test]
fn warped_cascades_err_less_on_a_long_scene() {
    let (scene, view) = scenes::long_row(SIZE);
    let lab = Bench::new(scene, view);
    let reference = lab.reference(0, &|_| {}).unwrap();
    let mismatch = |visibility: &[f32]| compare(visibility, &reference).unwrap().mismatch;
    let [one, same] = ["csm:resolution=512,cascades=1,warp=always", "lispsm:resolution=512,warp=always"]
        .map(|spec| warped(&lab, spec).1);
    assert!(one == same && one.contains(&0.0) && one.contains(&1.0));
    for cascades in [2, 3] {
        let [plain, auto] = ["none", "auto"].map(|warp| {
            let spec = format!("csm:resolution=256,cascades={cascades},warp={warp}");
            let (visibility, outside) = draw(&lab, &spec);
            assert_eq!(outside, 0, "{spec}");
            mismatch(&visibility)
        });
        println!("{cascades} slices: {plain} %, warped {auto} %");
        assert!(auto < 0.95 * plain, "{cascades} slices: {plain} %, warped {auto} %");
    }
}

/// A map for each face of the view frustum, under light from all around: each sample lies in the map of its face, warped faces err less
/// than faces alone, and where two maps meet there are no more errors than beside.
#[test]
fn frustum_faces_match_the_reference() {
    let (scene, view) = scenes::long_row(SIZE);
    let mut lab = Bench::new(scene, view.clone());
    let [right, up, back] = [0, 1, 2].map(|i| view.camera.view_from_world().row(i));
    let (mut parts, mut errors) = ([0usize; 5], [[0usize; 2]; 2]);
    // from above, from beside, from behind and from in front of the eye, the last two within the frustum's own angles too
    for (x, y, z) in [(0.0, -1.0, 0.0), (-0.9, -0.7, -0.3), (0.5, -0.6, 0.6), (0.1, -0.2, -1.0), (-0.1, -0.15, 1.0)] {
        let light = Light::directional(x * right + y * up + z * back);
        lab.look(View { lights: vec![light], ..view.clone() }).unwrap();
        let reference = lab.reference(0, &|_| {}).unwrap();
        let [plain, warped] = ["none", "always"].map(|warp| {
            let spec = format!("csm:resolution=1024,partition=faces,warp={warp}");
            let mut method = method(&lab, &spec).unwrap();
            method.frame(&lab).unwrap();
            let counters = method.statistics(&lab).unwrap().counters;
            let outside = counters.iter().find(|(name, _)| *name == "outside").unwrap().1;
            assert_eq!(outside, 0, "{spec}, light {x} {y} {z}");
            let visibility = method.visibility(&lab, 0).unwrap();
            let part: Vec<_> = method.sampling(&lab, 0).unwrap().unwrap().errors.iter().map(|e| e.part).collect();
            (visibility, part)
        });
        let truth = reference.visibility_image();
        let mismatch = [&plain, &warped].map(|(image, _)| compare(image, &reference).unwrap().mismatch);
        println!("light {x} {y} {z}: {:.3} %, warped {:.3} %", mismatch[0], mismatch[1]);
        assert!(mismatch[1] <= 1.05 * mismatch[0], "light {x} {y} {z}: {mismatch:?}");
        let (image, part) = &warped;
        assert!(image.contains(&0.0) && image.contains(&1.0));
        let [width, height] = SIZE.map(|n| n as usize);
        for (x, y) in (8..height - 8).flat_map(|y| (8..width - 8).map(move |x| (x, y))) {
            let own = part[y * width + x];
            let Some(face) = parts.get_mut(own as usize) else { continue };
            *face += 1;
            let meets = |reach: usize| {
                let side = 2 * reach + 1;
                let around = (0..side * side).map(|i| part[(y + i / side - reach) * width + x + i % side - reach]);
                around.filter(|p| *p != u32::MAX).any(|p| p != own)
            };
            // at a border, and beside it
            let wrong = (image[y * width + x] - truth[y * width + x]).abs() > 0.5;
            if meets(1) || meets(8) && !meets(2) {
                let of = &mut errors[usize::from(meets(1))];
                *of = [of[0] + usize::from(wrong), of[1] + 1];
            }
        }
    }
    println!("pixels of each face: {parts:?}, wrong beside borders and at them {errors:?}");
    assert!(parts.iter().all(|n| *n > 50), "{parts:?}");
    let [beside, border] = errors.map(|[wrong, all]| wrong as f64 / all as f64);
    assert!(errors[1][1] > 1000 && border <= 1.5 * beside + 0.001, "{border} at borders, beside them {beside}");
}

/// Where the light shines along the view, or nearly (duelling frusta), no warp gains anything: the map is the fitted one.
#[test]
fn a_light_along_the_view_is_not_warped() {
    let (scene, view) = scenes::long_row(SIZE);
    let forward = -view.camera.view_from_world().row(2);
    let tilted = |sign: f64, tilt: f64| Light::directional(sign * forward + DVec3::new(tilt, -0.4 * tilt, 0.3 * tilt));
    let mut lab = Bench::new(scene, view.clone());
    for (sign, tilt) in [(1.0, 0.0), (1.0, 0.01), (-1.0, 0.02)] {
        lab.look(View { lights: vec![tilted(sign, tilt)], ..view.clone() }).unwrap();
        let uniform = draw(&lab, "uniform:resolution=512").0;
        for spec in ["lispsm:resolution=512", "tsm:resolution=512", "psm:resolution=512"] {
            let (serves, visibility) = warped(&lab, spec);
            assert!(!serves, "{spec}, {sign}, {tilt}");
            assert!(visibility == uniform && uniform.contains(&0.0), "{spec}, {sign}, {tilt}");
        }
    }
    lab.look(View { lights: vec![tilted(1.0, 0.5)], ..view }).unwrap();
    assert!(warped(&lab, "lispsm:resolution=512,warp=always").0);
}

#[test]
fn logarithmic_splits_favour_the_near_range() {
    let (scene, view) = scenes::long_row(SIZE);
    let lab = Bench::new(scene, view);
    for fit in ["samples", "frustum"] {
        let finest = ["0", "0.5", "1"].map(|lambda| {
            let mut method = method(&lab, &format!("csm:resolution=512,lambda={lambda},fit={fit}")).unwrap();
            method.frame(&lab).unwrap();
            method.statistics(&lab).unwrap().effective_resolution
        });
        println!("fit={fit}: {finest:?}");
        assert!(finest[0] > 512.0 && finest[1] > 1.3 * finest[0] && finest[2] > 1.3 * finest[1], "{fit}: {finest:?}");
    }
}

/// A sample outside the map of its layer would be lit.
#[test]
fn every_sample_lies_in_the_map_of_its_layer() {
    let (scene, mut view) = scenes::under_a_roof(SIZE);
    let sun = view.lights[0].clone();
    let above = DVec3::new(1.0, 6.0, 2.0);
    let point = Light::Point { position: above, range: 100.0 };
    let wide = spot(above, DVec3::new(0.3, -1.0, 0.1), 89.0, 100.0);
    for (light, specs) in [
        (
            sun,
            &[
                "csm:resolution=64",
                "csm:resolution=64,fit=frustum",
                "csm:resolution=256,fit=frustum,snap=true",
                "csm:resolution=64,cascades=8",
                "csm:resolution=256,warp=always,blend=0.3",
                "csm:resolution=64,partition=faces,warp=always",
                "uniform",
                "lispsm:resolution=512,warp=always",
                "tsm:resolution=512,warp=always",
                "psm:resolution=512,warp=always",
                "plane_optimal:resolution=512,warp=always",
                "logpsm:resolution=512,warp=always",
                "logpsm:resolution=64,warp=always,filter=pcf",
                "asm",
                "asm_gpu",
                "silhouette:resolution=64",
                "triangle_store:resolution=64,neighbours=4",
                "forward:resolution=64",
                "fvsm:tile=64,tiles=40",
                "fvsm:tile=64,tiles=200,filter=pcf",
                "tiled:tile=256",
                "qvsm:tile=64,tiles=5",
                "rtw:resolution=256",
                "rtw:resolution=256,analysis=hybrid,subdivide=2.5",
            ][..],
        ),
        (
            point,
            &[
                "uniform:resolution=256",
                "uniform:resolution=256,fit=scene",
                "silhouette:resolution=256",
                "triangle_store:resolution=256",
                "forward:resolution=256",
            ],
        ),
        (wide, &["uniform:resolution=256", "uniform:resolution=256,fit=scene", "triangle_store:resolution=256"]),
    ] {
        view.lights = vec![light];
        let lab = Bench::new(scene.clone(), view.clone());
        let hit = lab.gbuffer().unwrap().hit.clone();
        for spec in specs {
            let (visibility, outside) = draw(&lab, spec);
            let lit = visibility.iter().zip(&hit).filter(|(v, hit)| **hit && **v > 0.0).count();
            assert_eq!((outside, lit), (0, 0), "{spec} with {:?}", view.lights[0]);
        }
        assert!(hit.iter().filter(|h| **h).count() * 2 > hit.len());
    }
}

fn spot(position: DVec3, direction: DVec3, outer_angle_deg: f64, range: f64) -> Light {
    Light::Spot { position, direction, inner_angle_deg: 0.0, outer_angle_deg, range }
}

fn with_light((scene, view): (Scene, View), light: &Light) -> (Scene, View) {
    (scene, View { lights: vec![light.clone()], ..view })
}

#[test]
fn lights_with_a_position_match_the_reference() {
    let at = DVec3::new(-2.0, 4.0, 1.5);
    let aim = DVec3::new(2.0, -4.0, -1.5);
    let lights = [
        spot(at, aim, 35.0, 20.0),
        // ends within the image
        spot(at, aim, 60.0, 6.0),
        // as a cube, from a corner of the scene
        spot(DVec3::new(-3.0, 1.6, 2.0), DVec3::new(1.0, -0.2, -0.4), 85.0, 20.0),
        Light::Point { position: at, range: 20.0 },
        // among the casters: faces to all sides are used
        Light::Point { position: DVec3::new(0.9, 2.4, 0.9), range: 7.0 },
    ];
    for light in &lights {
        for scene in [scenes::sphere_on_plane(SIZE), scenes::thin_poles(SIZE), scenes::leaves(SIZE)] {
            let (scene, view) = with_light(scene, light);
            let name = scene.name.clone();
            let lab = Bench::new(scene, view);
            let reference = lab.reference(0, &|_| {}).unwrap();
            for spec in ["uniform:resolution=2048", "uniform:resolution=4096,fit=scene"] {
                let (visibility, outside) = draw(&lab, spec);
                let name = format!("{name}, {spec}, {light:?}");
                near_truth(&name, &visibility, &reference);
                assert_eq!(outside, 0, "{name}");
                let beyond = (0..reference.hit.len())
                    .filter(|&i| reference.hit[i] && reference.decided[i] && !reference.facing[i])
                    .filter(|&i| visibility[i] != 0.0);
                assert_eq!(beyond.count(), 0, "{name}: pixels lit beyond the light's reach");
            }
        }
    }
}

#[test]
fn unserved_lights_are_refused() {
    let at = DVec3::new(0.0, 4.0, 0.0);
    let cone = spot(at, -DVec3::Y, 30.0, 10.0);
    let point = Light::Point { position: at, range: 10.0 };
    for (light, spec, word) in [
        (&cone, "csm", "directional"),
        (&point, "csm", "directional"),
        (&cone, "lispsm", "directional"),
        (&cone, "fvsm", "directional"),
        (&point, "qvsm", "directional"),
        (&point, "tiled", "directional"),
        (&point, "psm", "directional"),
        (&point, "logpsm", "directional"),
        (&point, "plane_optimal", "directional"),
        (&cone, "asm", "directional"),
        (&point, "asm_gpu", "directional"),
        (&cone, "temporal", "directional"),
        (&point, "hybrid", "directional"),
        (&cone, "rtw", "directional"),
        (&cone, "uniform:fit=frustum", "fit=frustum"),
        (&point, "uniform:fit=frustum", "fit=frustum"),
        (&cone, "silhouette:fit=frustum", "fit=frustum"),
        (&cone, "triangle_store:fit=frustum", "fit=frustum"),
        (&cone, "forward:fit=frustum", "fit=frustum"),
    ] {
        let (scene, view) = with_light(scenes::sphere_on_plane([16, 16]), light);
        let lab = Bench::new(scene, view);
        match method(&lab, spec) {
            Err(LabError::Refused(text)) => assert!(text.contains(word), "{spec}: {text}"),
            Err(other) => panic!("{spec}: {other}"),
            Ok(_) => panic!("{spec} serves {light:?}"),
        }
    }
}

#[test]
fn another_kind_of_light_is_refused_later() {
    let at = DVec3::new(0.0, 4.0, 0.0);
    let (scene, view) = scenes::sphere_on_plane([16, 16]);
    let mut lab = Bench::new(scene, view.clone());
    for spec in [
        "uniform:resolution=64",
        "csm:resolution=64",
        "lispsm:resolution=64",
        "logpsm:resolution=64",
        "plane_optimal:resolution=64",
        "temporal:resolution=64",
        "hybrid:resolution=64",
        "silhouette:resolution=64",
        "triangle_store:resolution=64",
        "forward:resolution=64",
        "fvsm:tiles=4",
        "qvsm:tiles=4",
        "tiled:tiles=4",
        "rtw:resolution=64",
        "asm",
        "asm_gpu",
    ] {
        let mut method = method(&lab, spec).unwrap();
        method.frame(&lab).unwrap();
        let cone = spot(at, -DVec3::Y, 30.0, 10.0);
        let sun = view.lights[0].clone();
        for (lights, words) in [
            (vec![cone], ["a spot light", "a directional light"]),
            (vec![sun.clone(), sun], ["2 lights", "made for 1"]),
        ] {
            lab.look(View { lights, ..view.clone() }).unwrap();
            let error = method.frame(&lab).unwrap_err().to_string();
            assert!(words.iter().all(|w| error.contains(w)), "{spec}: {error}");
        }
        lab.look(view.clone()).unwrap();
    }
}
