//! Temporal reprojection against ray tracing, and its weights and its history against a CPU twin.

use crate::bench::Bench;
use crate::comparators::{mixed, same_image};
use crate::scenes;
use glam::{DVec2, DVec3, DVec4, Vec3};
use umbrage::lab::{Lab, View};
use umbrage::methods::{Method, MethodSpec, SamplingInputs, create};
use umbrage::scene::{Changes, Scene};
use umbrage::truth::{GBuffer, compare};
use umbrage::{Camera, Light};

const SIZE: [u32; 2] = [320, 180];

fn method(lab: &Lab, spec: &str) -> Box<dyn Method> {
    create(&MethodSpec::parse(spec).unwrap(), lab).unwrap()
}

fn next(lab: &Lab, method: &mut dyn Method) -> Vec<f32> {
    method.frame(lab).unwrap();
    method.visibility(lab, 0).unwrap()
}

fn mismatch(lab: &Lab, visibility: &[f32]) -> f64 {
    compare(visibility, &lab.reference(0, &|_| {}).unwrap()).unwrap().mismatch
}

#[test]
fn a_still_view_converges() {
    for ((scene, view), side) in [(scenes::sphere_on_plane(SIZE), 64), (scenes::leaves(SIZE), 256)] {
        let name = scene.name.clone();
        let lab = Bench::new(scene, view);
        let mut method = method(&lab, &format!("temporal:resolution={side}"));
        let mut errs = Vec::new();
        for frame in 1..=64u32 {
            let visibility = next(&lab, method.as_mut());
            if frame.is_power_of_two() {
                errs.push(mismatch(&lab, &visibility));
            }
        }
        println!("{name}: {errs:?} % after 1, 2, 4 ... 64 frames");
        assert!(errs[0] > 0.2, "{name}: nothing to gain, {errs:?}");
        assert!(errs[6] < 0.1 && errs[4] < 0.4 * errs[0], "{name}: {errs:?}");
    }
}

/// The key `frames` draws that many from nothing, whatever was drawn before.
#[test]
fn frames_of_one_call() {
    let (scene, view) = scenes::sphere_on_plane(SIZE);
    let lab = Bench::new(scene, view);
    let mut one = method(&lab, "temporal:resolution=256");
    let singles: Vec<_> = (0..5).map(|_| next(&lab, one.as_mut())).collect();
    let mut five = method(&lab, "temporal:resolution=256,frames=5");
    for _ in 0..2 {
        same_image(&singles[4], &next(&lab, five.as_mut())).unwrap();
    }
    assert!(same_image(&singles[3], &singles[4]).is_err());
}

/// As `light_space` and the rest of `glsl/methods/temporal_blend.comp` before the history: a lookup's weight.
fn weight(inputs: &SamplingInputs, from_eye: DVec3, exponent: f64) -> f64 {
    let (face, fit) = (&inputs.light.faces[0], &inputs.fits[0]);
    let wide = |v: [f32; 4]| DVec4::from(v.map(f64::from));
    let across = |axis: [f32; 4]| wide(axis).dot(from_eye.extend(1.0));
    let t = DVec3::new(across(face.x), across(face.y), 1.0);
    let row = |row: [f32; 4]| wide(row).truncate().dot(t);
    let texel = DVec2::new(row(fit.row_u), row(fit.row_v)) * f64::from(inputs.side);
    let off = (texel - texel.floor() - 0.5).abs();
    // Eisemann et al. 2011, 4.7
    (1.0 - 2.0 * off.max_element()).max(0.0).powf(exponent)
}

fn inputs(lab: &Lab, method: &mut dyn Method) -> SamplingInputs {
    method.sampling(lab, 0).unwrap().and_then(|sampling| sampling.inputs).expect("a fitted map's inputs")
}

/// Visibility and weight of each pixel after a first frame.
fn first(lab: &Lab, method: &mut dyn Method, gbuffer: &GBuffer) -> Vec<[f64; 2]> {
    let visibility = next(lab, method);
    let inputs = inputs(lab, method);
    visibility
        .iter()
        .zip(&gbuffer.position)
        .map(|(v, p)| [f64::from(*v), weight(&inputs, Vec3::from(*p).as_dvec3(), 1.0)])
        .collect()
}

/// Counts of pixels that a twin explains and that it does not, and of those explained that are neither lit nor shadowed.
fn explained(seen: &[f32], gbuffer: &GBuffer, expected: impl Fn(usize) -> Option<[f64; 2]>) -> [usize; 3] {
    let mut counts = [0; 3];
    for i in (0..seen.len()).filter(|&i| gbuffer.hit[i]) {
        let Some(values) = expected(i) else { continue };
        let good = values.iter().any(|v| (v - f64::from(seen[i])).abs() < 4e-3);
        counts[usize::from(!good)] += 1;
        counts[2] += usize::from(good && seen[i] > 0.02 && seen[i] < 0.98);
    }
    counts
}

#[test]
fn a_second_frame_is_the_twins_mean() {
    let (scene, view) = scenes::leaves(SIZE);
    let lab = Bench::new(scene, view);
    let gbuffer = lab.gbuffer().unwrap();
    let mut method = method(&lab, "temporal:resolution=256,exponent=1");
    let before = first(&lab, method.as_mut(), &gbuffer);
    let seen = next(&lab, method.as_mut());
    let inputs = inputs(&lab, method.as_mut());
    let expected = |i: usize| {
        let ([v, w], fresh) = (before[i], weight(&inputs, Vec3::from(gbuffer.position[i]).as_dvec3(), 1.0));
        (w + fresh > 0.01).then(|| [0.0, 1.0].map(|lookup| (v * w + lookup * fresh) / (w + fresh)))
    };
    let [good, bad, between] = explained(&seen, &gbuffer, expected);
    println!("{good} explained, {bad} not, {between} between");
    assert!(good > 10_000 && between > 200 && bad * 500 < good);
    // a comparison that can fail
    let wrong = explained(&seen, &gbuffer, |i| Some([before[i][0], 0.5]));
    assert!(wrong[1] > between / 2, "{wrong:?}");
}

#[test]
fn a_moved_camera_finds_its_history_where_the_twin_does() {
    let (scene, view) = scenes::leaves(SIZE);
    let mut lab = Bench::new(scene, view.clone());
    let old = lab.gbuffer().unwrap();
    let mut method = method(&lab, "temporal:resolution=256,exponent=1");
    let before = first(&lab, method.as_mut(), &old);
    let project = inputs(&lab, method.as_mut()).frame.clip_from_eye;
    let mut moved = view.clone();
    moved.camera.eye += DVec3::new(0.013, 0.007, -0.02);
    moved.camera.target += DVec3::new(0.02, -0.01, 0.0);
    let shift = moved.camera.eye - view.camera.eye;
    lab.look(moved).unwrap();
    let seen = next(&lab, method.as_mut());
    let new = lab.gbuffer().unwrap();
    let inputs = inputs(&lab, method.as_mut());
    let [width, height] = SIZE.map(|v| v as usize);
    let expected = |i: usize| {
        let p = Vec3::from(new.position[i]).as_dvec3();
        let fresh = weight(&inputs, p, 1.0);
        let at = (p + shift).extend(1.0);
        let column = |c: usize| (0..4).map(|r| f64::from(project[r][c]) * at[r]).sum::<f64>();
        let place =
            (0.5 + 0.5 * DVec2::new(column(0), column(1)) / column(3)) * DVec2::new(width as f64, height as f64);
        let low = (place - 0.5).floor();
        let f = place - 0.5 - low;
        let (mut sum, mut shares) = ([0.0; 2], 0.0);
        for tap in 0..4usize {
            let step = DVec2::new((tap & 1) as f64, (tap >> 1) as f64);
            let at = low + step;
            // where taps are of several surfaces the twin does not say which the shader takes
            if at.min_element() < 0.0 || at.x >= width as f64 || at.y >= height as f64 {
                return None;
            }
            let j = at.y as usize * width + at.x as usize;
            let (n, m) = (Vec3::from(new.normal[i]).as_dvec3(), Vec3::from(old.normal[j]).as_dvec3());
            let off = (Vec3::from(old.position[j]).as_dvec3() - p - shift).dot(n);
            if !old.hit[j] || n.dot(m) < 0.99 || off.abs() > 1e-3 * p.length() {
                return None;
            }
            let share = (if tap & 1 == 1 { f.x } else { 1.0 - f.x }) * (if tap >> 1 == 1 { f.y } else { 1.0 - f.y });
            (sum[0], sum[1], shares) = (sum[0] + share * before[j][0], sum[1] + share * before[j][1], shares + share);
        }
        let [v, w] = sum.map(|sum| sum / shares);
        (w + fresh > 0.05).then(|| [0.0, 1.0].map(|lookup| (v * w + lookup * fresh) / (w + fresh)))
    };
    let [good, bad, between] = explained(&seen, &new, expected);
    println!("{good} explained, {bad} not, {between} between");
    assert!(good > 8_000 && between > 300 && bad * 100 < good);
    // without the move the twin explains far less
    let unmoved = explained(&seen, &new, |i| Some([before[i][0], before[i][0]]));
    assert!(unmoved[1] > 10 * bad.max(1), "{unmoved:?}");
}

/// What was hidden by a surface that faces the same way takes nothing of that one's history: ground in the shadow of a sheet, where the
/// lit sheet was seen before.
#[test]
fn what_comes_into_view_has_no_history() {
    let (scene, view) = scenes::awning(SIZE);
    let mut lab = Bench::new(scene, view.clone());
    let mut method = method(&lab, "temporal:resolution=1024");
    let before = (0..8).map(|_| next(&lab, method.as_mut())).last().unwrap();
    let (old, project) = (lab.gbuffer().unwrap(), inputs(&lab, method.as_mut()).frame.clip_from_eye);
    let shift = DVec3::new(0.0, -2.5, 2.0);
    lab.look(View { camera: Camera { eye: view.camera.eye + shift, ..view.camera }, ..view }).unwrap();
    let seen = next(&lab, method.as_mut());
    let (new, reference) = (lab.gbuffer().unwrap(), lab.reference(0, &|_| {}).unwrap());
    let [width, height] = SIZE.map(f64::from);
    let (mut uncovered, mut wrong) = (0, 0);
    for i in (0..seen.len()).filter(|&i| reference.decided[i] && reference.visibility[i] == 0) {
        let at = (Vec3::from(new.position[i]).as_dvec3() + shift).extend(1.0);
        let column = |c: usize| (0..4).map(|r| f64::from(project[r][c]) * at[r]).sum::<f64>();
        let place = (0.5 + 0.5 * DVec2::new(column(0), column(1)) / column(3)) * DVec2::new(width, height);
        if place.min_element() < 0.0 || place.x >= width || place.y >= height {
            continue;
        }
        let j = place.y as usize * SIZE[0] as usize + place.x as usize;
        let normals = [new.normal[i], old.normal[j]].map(|n| Vec3::from(n).as_dvec3());
        let off = (Vec3::from(old.position[j]).as_dvec3() - at.truncate()).dot(normals[0]);
        if old.hit[j] && normals[0].dot(normals[1]) > 0.99 && off.abs() > 0.1 && before[j] > 0.9 {
            uncovered += 1;
            wrong += usize::from(seen[i] > 0.1);
        }
    }
    println!("{wrong} of {uncovered} pixels have the history of what hid them");
    assert!(uncovered > 100 && wrong * 50 < uncovered);
}

/// Moves the instance of a scene's last mesh.
fn shift(lab: &mut Lab, by: Vec3) {
    let edit = |scene: &mut Scene| {
        let i = scene.instances.len() - 1;
        (0..3).for_each(|axis| scene.instances[i].rows[axis][3] += by[axis]);
        Ok(Changes { instances: vec![i as u32], ..Changes::default() })
    };
    lab.edit(edit).unwrap();
}

/// What moved leaves no ghost, in its own frame and in the next: errors are those of a method without a history.
#[test]
fn a_caster_that_moves_leaves_no_ghost() {
    let (scene, view) = scenes::sphere_on_plane(SIZE);
    let mut lab = Bench::new(scene, view);
    let mut kept = method(&lab, "temporal:resolution=64");
    (0..16).for_each(|_| drop(next(&lab, kept.as_mut())));
    let before = next(&lab, kept.as_mut());
    for step in 0..3 {
        shift(&mut lab, Vec3::new(0.25, 0.0, 0.1));
        let seen = next(&lab, kept.as_mut());
        let mut new = method(&lab, "temporal:resolution=64");
        let single = next(&lab, new.as_mut());
        let (ghost, fresh, stale) = (mismatch(&lab, &seen), mismatch(&lab, &single), mismatch(&lab, &before));
        println!("step {step}: {ghost} %, {fresh} % without history, {stale} % of the old image");
        mixed(&seen).unwrap();
        assert!(stale > 4.0 * fresh && ghost < 1.25 * fresh + 0.05, "step {step}");
    }
}

/// A light that moves takes the whole history with it.
#[test]
fn a_light_that_moves_starts_anew() {
    let (scene, view) = scenes::leaves(SIZE);
    let mut lab = Bench::new(scene, view.clone());
    let mut kept = method(&lab, "temporal:resolution=256");
    let before = (0..8).map(|_| next(&lab, kept.as_mut())).last().unwrap();
    lab.look(View { lights: vec![Light::directional(DVec3::new(0.4, -1.0, 0.35))], ..view }).unwrap();
    let mut new = method(&lab, "temporal:resolution=256");
    let seen = next(&lab, kept.as_mut());
    same_image(&seen, &next(&lab, new.as_mut())).unwrap();
    assert!(same_image(&seen, &before).is_err());
}

/// Where the map is coarse beside the image, an eye that moves slowly sees less errors than those of one frame. Where it is not, blur
/// outweighs them: see `docs/methods/temporal.md`.
#[test]
fn a_moving_eye_errs_less_than_one_frame() {
    let (scene, view) = scenes::sphere_on_plane(SIZE);
    let mut lab = Bench::new(scene, view.clone());
    let mut kept = method(&lab, "temporal:resolution=64");
    let (mut own, mut single) = (0.0, 0.0);
    for step in 0..12 {
        let mut moved = view.clone();
        moved.camera.eye += f64::from(step) * DVec3::new(0.01, 0.0, -0.006);
        lab.look(moved).unwrap();
        let seen = next(&lab, kept.as_mut());
        if step >= 4 {
            own += mismatch(&lab, &seen) / 8.0;
            let mut new = method(&lab, "temporal:resolution=64");
            single += mismatch(&lab, &next(&lab, new.as_mut())) / 8.0;
        }
    }
    println!("{own} % on the mean, {single} % of single frames");
    assert!(own < single && single > 0.1);
}
