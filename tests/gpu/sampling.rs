//! Sampling errors (book, 3.2): against their twin, against closed forms, and storage factors against the book's formulas.

use crate::bench::Bench;
use crate::scenes;
use glam::{DVec2, DVec3};
use umbrage::Light;
use umbrage::gpu::structs::SamplingError;
use umbrage::lab::stages::prepass;
use umbrage::lab::stages_tree::qvsm;
use umbrage::lab::{Lab, View};
use umbrage::methods::{MethodSpec, Sampling, create};
use umbrage::twin::receiver::linear_depth;
use umbrage::twin::sampling::sides;

const SIZE: [u32; 2] = [320, 180];

fn sampling(lab: &Lab, spec: &str) -> Sampling {
    let mut method = create(&MethodSpec::parse(spec).unwrap(), lab).unwrap();
    method.frame(lab).unwrap();
    method.sampling(lab, 0).unwrap().unwrap_or_else(|| panic!("{spec} tells no sampling errors"))
}

/// Most by which single precision may change a side where neither eye nor light graze the surface.
const ROUNDING: f64 = 2e-3;

/// Every pixel of a fitted map, but where rounding decides whether the light reaches it.
fn is_the_twins(lab: &Lab, spec: &str) -> Result<(), String> {
    let got = sampling(lab, spec);
    let inputs = got.inputs.as_ref().expect("a fitted map");
    let (depth, normal) = prepass(lab).unwrap();
    let mut compared = 0;
    for (i, error) in got.errors.iter().enumerate() {
        let pixel = [i as u32 % got.size[0], i as u32 / got.size[0]];
        let depth = if depth[i] > 0.0 { linear_depth(&inputs.frame, depth[i]) } else { 0.0 };
        let Some(want) = sides(inputs, pixel, depth, normal[i]) else {
            if error.part != SamplingError::NO_PART {
                return Err(format!("{spec}, {pixel:?}: {error:?} where nothing is"));
            }
            continue;
        };
        if want.margin < 1e-4 {
            continue;
        }
        if error.part != want.part {
            return Err(format!("{spec}, {pixel:?}: {error:?}, the twin's is {want:?}"));
        }
        if want.part == SamplingError::NO_PART {
            continue;
        }
        compared += 1;
        let tolerance = ROUNDING / want.grazing.max(1e-3);
        let values = [error.s, error.t, error.perspective_s, error.perspective_t];
        for (value, twin) in values.iter().zip(want.sides) {
            if (f64::from(*value) - twin).abs() > tolerance * twin {
                return Err(format!("{spec}, {pixel:?}: {error:?}, the twin's is {want:?}"));
            }
        }
    }
    if compared * 10 < got.errors.len() {
        return Err(format!("{spec}: only {compared} pixels were compared"));
    }
    Ok(())
}

#[test]
fn sampling_errors_are_the_twins() {
    let spot = Light::Spot {
        position: DVec3::new(-2.0, 4.0, 1.5),
        direction: DVec3::new(2.0, -4.0, -1.5),
        inner_angle_deg: 0.0,
        outer_angle_deg: 35.0,
        range: 20.0,
    };
    let point = Light::Point { position: DVec3::new(0.9, 2.4, 0.9), range: 7.0 };
    let (scene, view) = scenes::sphere_on_plane(SIZE);
    let faces = "csm:resolution=256,partition=faces,warp=always";
    let [right, back] = [0, 2].map(|i| view.camera.view_from_world().row(i));
    let [behind, before] = [-1.0, 1.0].map(|z| {
        let along = DVec3::new(z * back.x, 0.0, z * back.z).normalize();
        Light::directional(0.15 * right + along - 0.6 * DVec3::Y)
    });
    for (light, specs) in [
        (
            view.lights[0].clone(),
            &[
                "uniform:resolution=512",
                "lispsm:warp=always",
                "rtw:resolution=512",
                "rtw:resolution=512,fit=scene,normal=0",
                "logpsm:warp=always",
                "plane_optimal:warp=always",
                "csm:resolution=256,blend=0.2",
                faces,
            ][..],
        ),
        (behind, &[faces]),
        (before, &[faces]),
        (spot, &["uniform:resolution=512"]),
        (point, &["uniform:resolution=512", "uniform:resolution=512,fit=scene"]),
    ] {
        let lab = Bench::new(scene.clone(), View { lights: vec![light], ..view.clone() });
        for spec in specs {
            is_the_twins(&lab, spec).unwrap_or_else(|why| panic!("{why}"));
        }
    }
}

/// A pixel of `qvsm` has the texels of the round that it kept: those of one map as fine, halved from round to round.
#[test]
fn texels_of_levels_halve() {
    let (scene, view) = scenes::sphere_on_plane(SIZE);
    let lab = Bench::new(scene, view);
    let spec = "qvsm:tile=128,tiles=64,levels=3,threshold=0";
    let (_, served) = qvsm(&lab, spec).unwrap();
    let (tiles, one) = (sampling(&lab, spec), sampling(&lab, "uniform:resolution=128"));
    let mut seen = [0; 4];
    for (i, (tile, one)) in tiles.errors.iter().zip(&one.errors).enumerate() {
        if tile.part == SamplingError::NO_PART || one.part == SamplingError::NO_PART {
            continue;
        }
        seen[served[i] as usize] += 1;
        assert_eq!(tile.part >> 16, served[i], "pixel {i}");
        // borders: of each tile, and of the root in the fit
        let want = one.s / (1u32 << served[i]) as f32;
        assert!((tile.s / want - 1.0).abs() < 0.05, "pixel {i}, round {}: {} for {want}", served[i], tile.s);
        let projection = (tile.s / tile.perspective_s) / (one.s / one.perspective_s);
        assert!((projection - 1.0).abs() < 1e-3, "pixel {i}: {projection}");
    }
    assert!(seen[1] + seen[2] > 500 && seen[3] > 500, "{seen:?}");
}

/// Sides of a texel of flat ground at y = 0 in a pixel, and on the plane that light and view meet at equal angles: the texel's
/// edges, which lie across the light, are moved along it onto the plane and projected.
fn closed_form(view: &View, light: DVec3, edges: [DVec3; 2], pixel: usize) -> [f64; 4] {
    let [width, height] = view.size.map(f64::from);
    let axes = view.camera.view_from_world();
    let seen = |v: DVec3| DVec3::new(axes.row(0).dot(v), axes.row(1).dot(v), -axes.row(2).dot(v));
    let focal = 0.5 * height / (0.5 * view.camera.fov_y_deg.to_radians()).tan();
    let (column, row) = ((pixel as u32 % view.size[0]) as f64, (pixel as u32 / view.size[0]) as f64);
    let (x, y) = ((column + 0.5 - 0.5 * width) / focal, (0.5 * height - 0.5 - row) / focal);
    let ray = axes.row(0) * x + axes.row(1) * y - axes.row(2);
    let at = seen(ray * (-view.camera.eye.y / ray.y));
    let side = |edge: DVec3, normal: DVec3| {
        let e = seen(edge - light * (normal.dot(edge) / normal.dot(light)));
        DVec2::new(e.x * at.z - at.x * e.z, e.y * at.z - at.y * e.z).length() * focal / (at.z * at.z)
    };
    let even = ray.normalize() + light;
    let [a, b] = edges;
    [side(a, DVec3::Y), side(b, DVec3::Y), side(a, even), side(b, even)]
}

/// Whatever the size of the image, there is an error for each pixel and a picture can be drawn of them.
#[test]
fn images_of_any_size() {
    for size in [[1, 1], [7, 3], [33, 17]] {
        let (scene, view) = scenes::sphere_on_plane(size);
        let lab = Bench::new(scene, view);
        for spec in ["uniform:resolution=64", "rmsm:atlas_mib=1", "fvsm:tile=64,tiles=4"] {
            let got = sampling(&lab, spec);
            assert_eq!(got.errors.len(), (size[0] * size[1]) as usize, "{spec}, {size:?}");
            assert_eq!(got.pictures().unwrap().len(), 7, "{spec}, {size:?}");
        }
    }
}

/// On flat ground under a known light the sides of a texel follow from the camera alone. Pages have the light's axes and texels
/// that are whole powers of two apart.
#[test]
fn flat_ground_has_the_sides_of_the_closed_form() {
    let (scene, mut view) = scenes::slope([160, 90], 0.0);
    for direction in [DVec3::NEG_Y, DVec3::new(0.25, -1.0, 0.2), DVec3::new(-0.9, -0.5, 0.6)] {
        view.lights = vec![Light::directional(direction)];
        let lab = Bench::new(scene.clone(), view.clone());
        let got = sampling(&lab, "uniform:resolution=512,fit=scene");
        let inputs = got.inputs.as_ref().unwrap();
        let light = direction.normalize();
        let axis = |a: [f32; 4]| DVec3::new(a[0].into(), a[1].into(), a[2].into());
        let [x, y] = [inputs.light.faces[0].x, inputs.light.faces[0].y].map(axis);
        // a texel's side is 1 / 512 of where u grows by 1
        let across = |row: [f32; 4]| {
            let v = x * f64::from(row[0]) + y * f64::from(row[1]);
            v / v.length_squared() / 512.0
        };
        let edges = [across(inputs.fits[0].row_u), across(inputs.fits[0].row_v)];
        assert!(edges.iter().all(|e| e.dot(light).abs() < 1e-6 && e.length() > 0.3 * 8.0 / 512.0), "{edges:?}");
        let near = |value: f64, want: f64| (value - want).abs() < 2e-3 * want;
        let samples = |s: &Sampling| {
            let some = s.errors.iter().enumerate().filter(|(_, e)| e.part != SamplingError::NO_PART);
            some.map(|(i, e)| (i, [e.s, e.t, e.perspective_s, e.perspective_t].map(f64::from))).collect::<Vec<_>>()
        };
        let all = samples(&got);
        for (i, values) in &all {
            let want = closed_form(&view, light, edges, *i);
            assert!(
                values.iter().zip(want).all(|(v, w)| near(*v, w)),
                "{direction}, pixel {i}: {values:?}, not {want:?}"
            );
        }
        assert!(all.len() > 4000, "{} pixels", all.len());

        let pages = samples(&sampling(&lab, "rmsm"));
        let mut levels = Vec::new();
        let mut first = None;
        for (i, values) in &pages {
            let want = closed_form(&view, light, [x, y], *i);
            let texel = values[0] / want[0];
            assert!(values.iter().zip(want).all(|(v, w)| near(*v, texel * w)), "{direction}, pixel {i}: {values:?}");
            let level = (texel / *first.get_or_insert(texel)).log2();
            assert!((level - level.round()).abs() < 5e-3, "{direction}, pixel {i}: level {level}");
            levels.push(level.round() as i32);
        }
        levels.sort_unstable();
        levels.dedup();
        assert!(pages.len() == all.len() && levels.len() > 1, "{} pixels, levels {levels:?}", pages.len());
    }
}

/// What flat ground seen from `near` to `far` needs of a map whose line lies `n` before its first sample (book, 4.21 and 4.22,
/// with sin(gamma), by which light that is not overhead shortens the ground's image in the map). `tan`: of half the opening.
fn warped_storage([near, far]: [f64; 2], n: f64, sine: f64, tan: f64) -> f64 {
    let extent = (far - near) * sine;
    let f = n + extent;
    let along = (n * n / near).max(f * f / far) * extent / (f * n) / (2.0 * tan);
    let [first, last] = [n / near, f / far];
    along * (first / last).max(last / first)
}

/// The same of a map that is logarithmic along the view (book, 4.33 to 4.35).
fn logarithmic_storage([near, far]: [f64; 2], n: f64, sine: f64, tan: f64) -> f64 {
    let f = n + (far - near) * sine;
    let [first, last] = [n / near, f / far];
    first.max(last) * (f / n).ln() / (2.0 * tan) * (first / last).max(last / first)
}

/// What `count` slices whose ends have the same ratio need together without and with a warp (book, 4.38 to 4.40 as corrected).
fn slices_storage(ratio: f64, count: i32, tan: f64) -> [f64; 2] {
    let slice = ratio.powf(1.0 / f64::from(count));
    let warped = f64::from(count) * (slice - 1.0) / (2.0 * tan);
    [slice * warped, warped]
}

/// Storage factors of the methods on the scene that the book's formulas assume, for light at 90 to 20 degrees from the view:
/// prints the table of `docs/methods/sampling_error.md`.
#[test]
fn storage_factors_are_those_of_the_formulas() {
    let (height, fov) = (512u32, 20.0f64);
    let tan = (0.5 * fov.to_radians()).tan();
    // rows of pixels whose centres see the first and the last of the ground
    let depth = |row: f64| 0.5 * f64::from(height) / (row * tan);
    let near = depth(0.5 * f64::from(height) - 0.5);
    let far = depth(15.5);
    let (scene, view) = scenes::ground([height; 2], depth(15.25), fov);
    let mut lab = Bench::new(scene, view.clone());
    let ratio = far / near;
    println!("ground from {near:.3} to {far:.3}: z_f / z_n = {ratio:.2}");
    for gamma in [90.0f64, 75.0, 60.0, 45.0, 30.0, 20.0] {
        let (sine, cosine) = gamma.to_radians().sin_cos();
        lab.look(View { lights: vec![Light::directional(DVec3::new(0.0, -sine, -cosine))], ..view.clone() }).unwrap();
        let extent = (far - near) * sine;
        let uniform = ratio * (ratio - 1.0) * sine / (2.0 * tan);
        let warped = |n| warped_storage([near, far], n, sine, tan);
        let logarithmic = |n| logarithmic_storage([near, far], n, sine, tan);
        let cases = [
            ("uniform:resolution=1024", uniform),
            ("psm:resolution=1024,warp=always", warped(near * sine - cosine)),
            ("tsm:resolution=1024,warp=always", warped(0.12 * extent)),
            ("lispsm:resolution=1024,warp=always", warped((near + (near * (near + extent * sine)).sqrt()) / sine)),
            ("logpsm:resolution=1024,warp=always", logarithmic(near * sine)),
            ("logpsm:resolution=1024,warp=always,line=eye", logarithmic(near * sine - cosine)),
        ];
        let slices = slices_storage(ratio, 4, tan);
        let partitioned = [
            ("csm:resolution=512,cascades=4", slices[0] * sine),
            ("csm:resolution=512,cascades=4,warp=always", slices[1] * sine),
            // all of the ground lies behind one face
            ("csm:resolution=512,partition=faces,warp=always", warped_storage([near, far], near, 1.0, tan)),
        ];
        let factor =
            |method: &str, warp| sampling(&lab, &format!("csm:resolution=512,{method},warp={warp}")).storage_factor();
        let [slices, faces] =
            ["cascades=4", "partition=faces"].map(|method| ["none", "always"].map(|warp| factor(method, warp)));
        println!("| {gamma} | four slices {slices:.1?} and faces {faces:.1?}, without a warp and with one |");
        // with few maps slices need less than faces (Lloyd et al. 2006; book, fig. 4.19), which are for warping
        assert!(slices[1] < faces[1] && faces[1] < 0.25 * faces[0], "{gamma} degrees: {slices:?}, {faces:?}");
        // the latter with a line that is best for light from above
        for (spec, formula) in cases.into_iter().chain(partitioned.into_iter().filter(|_| gamma > 80.0)) {
            let measured = sampling(&lab, spec).storage_factor();
            println!("| {gamma} | {spec} | {formula:.2} | {measured:.2} | {:.3} |", measured / formula);
            // the formulas hold on the middle line: beside it rays leave the plane through light and view
            let aside = (1.0 + (tan / sine).powi(2)).sqrt();
            let off = measured / formula / aside;
            assert!(off > 0.9 && off < 1.04, "{spec} at {gamma} degrees: {measured}, the formula has {formula}");
        }
    }
}
