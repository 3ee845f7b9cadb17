//! Plane-optimal warps: texels of one size on a plane against the closed form, the plane that is found against the one of the scene,
//! lines that samples stand in the way of.

use crate::bench::{Bench, Lcg};
use crate::comparators::same_image;
use crate::maps::{draw, method};
use crate::scenes;
use glam::{DVec2, DVec3};
use umbrage::Light;
use umbrage::gpu::structs::SamplingError;
use umbrage::lab::stages::prepass;
use umbrage::lab::{Lab, View};
use umbrage::methods::Sampling;
use umbrage::truth::compare;
use umbrage::twin::receiver::{decode_normal, linear_depth};

/// Sampling errors of a frame, and its counters.
fn sampling(lab: &Lab, spec: &str) -> (Sampling, Vec<(&'static str, u64)>) {
    let mut method = method(lab, spec).unwrap();
    method.frame(lab).unwrap();
    (method.sampling(lab, 0).unwrap().unwrap(), method.statistics(lab).unwrap().counters)
}

fn counter(counters: &[(&str, u64)], name: &str) -> u64 {
    counters.iter().find(|(n, _)| *n == name).unwrap_or_else(|| panic!("{name} in {counters:?}")).1
}

/// The texels' sides on the plane with this normal: the map's axes in the image are the plane's horizon and what is upright on it, and the
/// box of the samples' middles fills the map but for a texel on each side.
fn closed_form(view: &View, normal: DVec3, side: f64, samples: &[usize]) -> [f64; 2] {
    let axes = view.camera.view_from_world();
    let horizon = DVec2::new(axes.row(0).dot(normal.cross(axes.row(2))), -axes.row(1).dot(normal.cross(axes.row(2))));
    let horizon = horizon.normalize();
    let extent = |axis: DVec2| {
        let at =
            |i: &usize| axis.dot(DVec2::new((i % view.size[0] as usize) as f64, (i / view.size[0] as usize) as f64));
        let all = samples.iter().map(at);
        all.clone().fold(f64::MIN, f64::max) - all.fold(f64::MAX, f64::min)
    };
    [horizon, horizon.perp()].map(|axis| extent(axis) / (side - 2.0))
}

/// On one plane, be it aslant and the camera rolled, both sides of a texel are the same in all pixels, and as long as they are in a map that
/// has the box of the plane's image.
#[test]
fn texels_look_alike_all_over_a_plane() {
    for (slope, up, light) in [
        (0.0, DVec3::Y, DVec3::new(0.25, -1.0, 0.2)),
        (0.0, DVec3::new(1.0, 0.8, 0.1), DVec3::new(-0.9, -0.5, 0.6)),
        (0.35, DVec3::Y, DVec3::new(0.25, -1.0, 0.2)),
        (-0.4, DVec3::new(-0.6, 1.0, 0.2), DVec3::new(0.7, -0.8, -0.5)),
    ] {
        let (scene, mut view) = scenes::slope([160, 90], slope);
        view.camera.up = up;
        view.camera.eye = DVec3::new(1.0, 3.0, 4.6);
        view.camera.target = DVec3::new(0.4, 0.0, 1.0);
        view.lights = vec![Light::directional(light)];
        let lab = Bench::new(scene, view.clone());
        let normal = DVec3::new(-slope, 1.0, -0.5 * slope);
        let given = format!("plane={}/{}/{}/0", normal.x, normal.y, normal.z);
        let mut warps = Vec::new();
        for plane in ["plane=auto", &given] {
            let spec = format!("plane_optimal:resolution=512,warp=always,{plane}");
            let (got, counters) = sampling(&lab, &spec);
            assert_eq!((counter(&counters, "warped"), counter(&counters, "line_moved")), (1, 0), "{spec}");
            let on: Vec<usize> =
                (0..got.errors.len()).filter(|i| got.errors[*i].part != SamplingError::NO_PART).collect();
            assert!(on.len() > 4000, "{spec}: {} pixels", on.len());
            let want = closed_form(&view, normal, 512.0, &on);
            let mut range = [[f64::MAX, f64::MIN]; 2];
            for i in &on {
                for (range, value) in range.iter_mut().zip([got.errors[*i].s, got.errors[*i].t].map(f64::from)) {
                    *range = [range[0].min(value), range[1].max(value)];
                }
            }
            println!("slope {slope}, {spec}: s, t {range:?}, closed form {want:?}");
            for ([low, high], want) in range.into_iter().zip(want) {
                assert!(
                    high < 1.001 * low && high < 1.001 * want && low > 0.999 * want,
                    "{spec}: {low} to {high}, not {want}"
                );
            }
            warps.push(got);
        }
        let off = difference(&warps[0], &warps[1]);
        assert!(off < 2e-4, "slope {slope}: found and given plane differ by {off}");
        // without the warp they are not alike
        let (uniform, _) = sampling(&lab, "uniform:resolution=512");
        let [low, high] = uniform.samples().fold([f32::MAX, 0.0], |[l, h], e| [l.min(e.t), h.max(e.t)]);
        assert!(high > 1.5 * low, "slope {slope}: {low} to {high}");
    }
}

/// Greatest difference of two warps, as a share of the largest number of each row.
fn difference(a: &Sampling, b: &Sampling) -> f32 {
    let [a, b] = [a, b].map(|s| s.inputs.as_ref().unwrap().fits[0]);
    let rows = [(a.row_u, b.row_u), (a.row_v, b.row_v), (a.row_w, b.row_w)];
    let off = |(a, b): ([f32; 4], [f32; 4])| {
        let scale = b.iter().fold(0f32, |m, v| m.max(v.abs()));
        a.iter().zip(b).fold(0f32, |m, (a, b)| m.max((a - b).abs() / scale))
    };
    rows.into_iter().map(off).fold(0.0, f32::max)
}

/// The floor under boxes is found, however it lies: as many samples as the CPU counts on it, and the warp of the floor's own plane.
#[test]
fn the_dominant_plane_is_the_floor() {
    for seed in [1, 2, 3, 4] {
        let (scene, view, normal, offset) = scenes::tilted_floor([160, 90], seed);
        let light = view.lights[0].clone();
        let Light::Directional { direction, .. } = light else { unreachable!() };
        let eye = view.camera.eye;
        let lab = Bench::new(scene, view);
        let given = format!("plane={}/{}/{}/{offset}", normal.x, normal.y, normal.z);
        let [(found, counters), (want, _)] =
            ["plane=auto", &given].map(|plane| sampling(&lab, &format!("plane_optimal:warp=always,{plane}")));
        let frame = found.inputs.as_ref().unwrap().frame;
        let (depth, normals) = prepass(&lab).unwrap();
        let (mut floor, mut lit) = (0u64, 0u64);
        for (i, depth) in depth.iter().enumerate().filter(|(_, depth)| **depth > 0.0) {
            let ray = |v: [f32; 4]| DVec3::new(v[0].into(), v[1].into(), v[2].into());
            let (x, y) = ((i % 160) as f64 + 0.5, (i / 160) as f64 + 0.5);
            let ray = ray(frame.ray_corner) + x * ray(frame.ray_dx) + y * ray(frame.ray_dy);
            let at = eye + ray * f64::from(linear_depth(&frame, *depth));
            let facing = decode_normal(normals[i]).as_dvec3();
            lit += u64::from(facing.dot(direction) < 0.0);
            floor += u64::from((normal.dot(at) - offset).abs() < 1e-3 && facing.dot(normal) > 0.999);
        }
        let samples = counter(&counters, "plane_samples");
        println!(
            "seed {seed}: {samples} samples in the plane, {floor} on the floor of {lit} lit, {}",
            difference(&found, &want)
        );
        assert!(
            floor * 20 < lit * 19 && samples.abs_diff(floor) * 50 < floor,
            "seed {seed}: {samples}, {floor} of {lit}"
        );
        let off = difference(&found, &want);
        assert!(off < 2e-4, "seed {seed}: {off}");
    }
}

/// Small plates over flat ground: their shadows are on the plane, and err less than by the other maps of this size.
#[test]
fn shadows_on_the_plane_err_least() {
    let (scene, view) = scenes::plates([320, 180]);
    let lab = Bench::new(scene, view);
    let reference = lab.reference(0, &|_| {}).unwrap();
    let [own, uniform, lispsm, screen] = [
        "plane_optimal:resolution=256",
        "uniform:resolution=256",
        "lispsm:resolution=256",
        "plane_optimal:resolution=512",
    ]
    .map(|spec| compare(&draw(&lab, spec).0, &reference).unwrap().edge_error);
    println!("edge error: {own} %, uniform {uniform} %, lispsm {lispsm} %; 512 texels a side {screen} %");
    assert!(own < 0.5 * uniform && own < lispsm && screen < 0.7 * own);
}

/// What lies behind the plane's line: the line moves before it, no sample is lost, and texels on the plane are not alike any more.
#[test]
fn samples_behind_the_line_move_it() {
    let (scene, mut view, ..) = scenes::tilted_floor([160, 90], 1);
    let forward = -view.camera.view_from_world().row(2);
    let mut seen = [0u32; 2];
    let mut lcg = Lcg(5);
    let eye = view.camera.eye;
    let mut lab = Bench::new(scene, view.clone());
    for _ in 0..12 {
        let across = DVec3::new(lcg.between(-1.0, 1.0), lcg.between(-1.0, 1.0), lcg.between(-1.0, 1.0));
        view.lights = vec![Light::directional(across - 0.4 * DVec3::Y)];
        lab.look(view.clone()).unwrap();
        // any plane between the eye and what it sees
        let normal = DVec3::new(lcg.between(-1.0, 1.0), 1.0, lcg.between(-1.0, 1.0));
        let at = eye + lcg.between(0.5, 6.0) * forward;
        let spec = format!(
            "plane_optimal:resolution=256,warp=always,plane={}/{}/{}/{}",
            normal.x,
            normal.y,
            normal.z,
            normal.dot(at)
        );
        let (got, counters) = sampling(&lab, &spec);
        let moved = counter(&counters, "line_moved");
        seen[moved as usize] += 1;
        assert_eq!(counter(&counters, "outside"), 0, "{spec}");
        let inputs = got.inputs.as_ref().unwrap();
        assert!(inputs.fits[0].row_w[..2].iter().any(|w| *w != 0.0), "{spec}: no warp");
    }
    println!("lines: {} stayed, {} moved", seen[0], seen[1]);
    assert!(seen[0] > 1 && seen[1] > 1, "{seen:?}");
}

/// A plane across the view, through the eye or along the light has no line: the map is the fitted one. The same frame twice is one.
#[test]
fn planes_without_a_line_need_no_warp() {
    let (scene, view) = scenes::sphere_on_plane([160, 90]);
    let lab = Bench::new(scene, view.clone());
    let uniform = draw(&lab, "uniform:resolution=256").0;
    let forward = -view.camera.view_from_world().row(2);
    let Light::Directional { direction, .. } = view.lights[0] else { unreachable!() };
    let aside = direction.cross(forward);
    for (normal, offset) in [(forward, 0.0), (DVec3::Y, view.camera.eye.y), (aside, 3.0)] {
        let plane = format!("{}/{}/{}/{offset}", normal.x, normal.y, normal.z);
        // the eye is on a plane only to rounding
        let spec = format!("plane_optimal:resolution=256,warp=always,plane={plane}");
        let (_, counters) = sampling(&lab, &spec);
        assert_eq!(counter(&counters, "warped"), 0, "{spec}");
        same_image(&draw(&lab, &spec).0, &uniform).unwrap();
    }
    let mut method = method(&lab, "plane_optimal:resolution=256").unwrap();
    let images = [(); 3].map(|_| {
        method.frame(&lab).unwrap();
        method.visibility(&lab, 0).unwrap()
    });
    images.windows(2).for_each(|pair| same_image(&pair[0], &pair[1]).unwrap());
}
