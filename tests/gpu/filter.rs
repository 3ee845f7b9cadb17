//! Filtered shadows: kernels across pages against the same kernels on a map without pages, and what no kernel may do.

use crate::bench::Bench;
use crate::lights::{point, spot};
use crate::scenes::{self, SHEET_EDGE};
use glam::{DVec2, DVec3};
use std::collections::{BTreeMap, BTreeSet};
use umbrage::gpu::structs::{LightRecord, light_kind};
use umbrage::lab::stages::{EngineStage, ScreenStage, Seen, Table, frame_constants, prepass};
use umbrage::methods::{MethodSpec, create};
use umbrage::twin::contour::contour;
use umbrage::twin::key::{key_ancestor, key_level, key_of};
use umbrage::twin::light::{Receiver, blend, level, receiver};
use umbrage::twin::receiver::{decode_derivatives, decode_normal, pixel_ray};
use umbrage::twin::{ROOT_LEVEL, kernel};
use umbrage::{Config, Error, Filter, Light, RequestRoute};

const SIZE: [u32; 2] = [240, 136];

fn kinds(taps: u32) -> [Filter; 3] {
    [Filter::Pcf { taps }, Filter::Poisson { taps }, Filter::Bilinear { taps }]
}

/// Small pages, all of which fit and are drawn at once.
fn config(filter: Filter) -> Config {
    Config {
        filter,
        gutter: filter.reach(),
        page_texels: 64,
        atlas_bytes: 1024 * 4 * 64 * 64,
        level_bias: 0.0,
        pages_per_frame: 4096,
        sun_pages_per_frame: 4096,
        ..Config::new(SIZE)
    }
}

fn lights() -> [Light; 3] {
    [
        Light::directional(DVec3::new(0.25, -1.0, 0.2)),
        spot([-0.6, 4.0, 0.5], [0.3, 0.0, 0.2], 50.0, 20.0),
        point([-0.4, 3.1, 0.3], 20.0),
    ]
}

fn image(lab: &Bench, config: &Config) -> (Vec<f32>, Table) {
    EngineStage::new(lab, config).unwrap().frame(lab).unwrap()
}

#[test]
fn what_a_filter_needs_is_said() {
    let lab = Bench::plain();
    let size = lab.view().size;
    let wide = Filter::Bilinear { taps: 9 };
    let small = |filter| Config { size, ..config(filter) };
    let refused = |config: Config| match EngineStage::new(&lab, &config) {
        Err(umbrage::lab::LabError::Engine(Error::Limit { field, limit, .. })) => (field, limit),
        Err(other) => panic!("{config:?}: {other}"),
        Ok(_) => panic!("{config:?} is allowed"),
    };
    for taps in [0, 1, 10] {
        assert_eq!(refused(Config { gutter: 8, ..small(Filter::Pcf { taps }) }).0, "filter");
    }
    assert_eq!(refused(Config { gutter: 4, ..small(wide) }), ("gutter", "5 to 8 texels with this filter".into()));
    assert_eq!(
        refused(Config { mask_bits: 1, ..small(wide) }),
        ("mask_bits", "8 or 32 with a filter or with several samples a pixel".into())
    );
    assert_eq!(refused(Config { level_blend: true, ..small(Filter::Hard) }).0, "level_blend");
    EngineStage::new(&lab, &Config { mask_bits: 8, level_blend: true, ..small(wide) }).unwrap();
}

/// A receiver on the floor as the endless map of a light sees it.
struct Sample {
    pixel: [u32; 2],
    receiver: Receiver,
}

/// The pixels at heights to be `wanted` that the light certainly reaches.
fn samples(lab: &Bench, config: &Config, wanted: impl Fn(f64) -> bool) -> (LightRecord, Vec<Sample>) {
    let (frame, lights) = frame_constants(lab, config).unwrap();
    let (depth, normal) = prepass(lab).unwrap();
    let stage = ScreenStage::new(lab, SIZE, RequestRoute::Flags, 1024, 1).unwrap();
    let Seen { depth, planes: packed } = stage.gradient(lab, &frame, &depth, Some(&normal)).unwrap();
    let eye = lab.view().camera.eye;
    let sample = |i: usize| {
        let pixel = [i as u32 % SIZE[0], i as u32 / SIZE[0]];
        let linear = depth[i];
        let from_eye = pixel_ray(&frame, pixel) * linear;
        if depth[i] <= 0.0 || !wanted(eye.y + f64::from(from_eye.y)) {
            return None;
        }
        let n = decode_normal(packed[i][0]);
        let receiver = receiver(&frame, &lights[0], from_eye, n, decode_derivatives(&frame, packed[i], linear))?;
        (receiver.margin > 0.01).then_some(Sample { pixel, receiver })
    };
    (lights[0], (0..depth.len()).filter_map(sample).collect())
}

/// Rotations that turn the faces of a cube to the front, as rows; see `glsl/shared/light.glsl`.
fn face_rows(face: u32) -> [DVec3; 3] {
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    match face {
        1 => [-x, y, -z],
        2 => [-z, y, x],
        3 => [z, y, -x],
        4 => [x, -z, y],
        5 => [x, z, -y],
        _ => [x, y, z],
    }
}

/// Whether the ray of a light through a point of its face, in units from the corner, passes beside the sheet.
fn passes(light: &LightRecord, origin: DVec3, eye: DVec3, face: u32, units: DVec2) -> bool {
    let axis = |v: [f32; 4]| DVec3::new(v[0].into(), v[1].into(), v[2].into());
    let [x, y, z] = [light.axis_x, light.axis_y, light.axis_z].map(axis);
    let half = f64::from(1 << (ROOT_LEVEL - 1));
    let height = SHEET_EDGE[0][1];
    let hit = if light.kind[0] == light_kind::DIRECTIONAL {
        let from_eye = [0, 1].map(|i| {
            let inside = f64::from([light.axis_x[3], light.axis_y[3]][i]);
            (units[i] - f64::from(light.eye_page[i]) - inside) * f64::from(light.scale[1])
        });
        let start = eye + x * from_eye[0] + y * from_eye[1];
        start + z * ((height - start.y) / z.y)
    } else {
        let tan = f64::from(light.axis_x[3]);
        let across = (units - half) / half;
        let [a, b, c] = face_rows(face);
        let local = a * across.x + b * across.y + c;
        let ray = x * (local.x * tan) + y * (local.y * tan) + z * local.z;
        let start = origin + axis(light.place);
        start + ray * ((height - start.y) / ray.y)
    };
    let [from, to] = SHEET_EDGE.map(DVec3::from);
    hit.x > from.x + (to.x - from.x) * (hit.z - from.z) / (to.z - from.z)
}

/// The sheet's shadow by a kernel over texels of a level's whole face.
struct Endless<'a> {
    light: LightRecord,
    origin: DVec3,
    eye: DVec3,
    config: &'a Config,
}

impl Endless<'_> {
    /// Texel of the level's whole face.
    fn texel(&self, s: &Sample, level: i32) -> DVec2 {
        let page = DVec2::new(s.receiver.page[0].into(), s.receiver.page[1].into());
        (page + s.receiver.units.as_dvec2()) / f64::from(1 << level) * self.interior()
    }

    fn interior(&self) -> f64 {
        f64::from(self.config.page_texels - 2 * self.config.gutter)
    }

    /// Visibility with the receiver and the sheet moved by parts of a texel.
    fn visibility(&self, s: &Sample, level: i32, receiver: DVec2, sheet: DVec2) -> f64 {
        self.filtered(self.config.filter, s, level, receiver, sheet)
    }

    /// Whether the texels that are read differ.
    fn partial(&self, s: &Sample, level: i32) -> bool {
        let kernel = if self.config.filter == Filter::Hard { Filter::Pcf { taps: 4 } } else { self.config.filter };
        (1e-6..1.0 - 1e-6).contains(&self.filtered(kernel, s, level, DVec2::ZERO, DVec2::ZERO))
    }

    fn filtered(&self, filter: Filter, s: &Sample, level: i32, receiver: DVec2, sheet: DVec2) -> f64 {
        let texel = self.texel(s, level) + receiver;
        let lit = |place: [i64; 2]| {
            let centre = DVec2::new(place[0] as f64 + 0.5, place[1] as f64 + 0.5) + sheet;
            let units = centre / self.interior() * f64::from(1 << level);
            passes(&self.light, self.origin, self.eye, s.receiver.face, units)
        };
        if filter == Filter::Hard {
            return f64::from(u8::from(contour(texel.to_array(), lit)));
        }
        let taps = kernel::taps(filter, texel.to_array(), s.pixel);
        taps.into_iter().filter(|tap| lit(tap.0)).map(|tap| tap.1).sum()
    }
}

/// Level of the page that serves an ask for `level`.
fn serving(entries: &BTreeMap<u64, u32>, s: &Sample, level: i32) -> i32 {
    let base = [0, 1].map(|i| s.receiver.page[i] + s.receiver.units[i].floor() as i32);
    let key = key_of(level, s.receiver.face, base.map(|c| c as u32 >> level));
    let entry = (0..=(ROOT_LEVEL - key_level(key)) as u32).find_map(|steps| entries.get(&key_ancestor(key, steps)));
    (entry.expect("a page for every receiver") >> 26 & 31) as i32
}

/// Texels by which rounding and the rasterizer's grid may move an edge.
const NEAR: f64 = 0.02;

fn pages_leave_no_trace(light: &Light, filter: Filter) {
    let (scene, mut view) = scenes::sheet_over_floor(SIZE);
    view.lights = vec![light.clone()];
    let lab = Bench::new(scene, view);
    let config = config(filter);
    let (got, table) = image(&lab, &config);
    let (record, samples) = samples(&lab, &config, |height| height.abs() < 1e-3);
    let (origin, eye) = (lab.scene().origin, lab.view().camera.eye);
    let endless = Endless { light: record, origin, eye, config: &config };
    let entries: BTreeMap<u64, u32> =
        table.keys.iter().copied().zip(table.entries.iter().copied()).filter(|e| e.0 != 0).collect();
    let corners = [[0.0, 0.0], [-NEAR, -NEAR], [NEAR, -NEAR], [-NEAR, NEAR], [NEAR, NEAR]].map(DVec2::from);
    let (mut partial, mut moved, mut across, mut pages) = (0, 0, 0, BTreeSet::new());
    for s in &samples {
        let r = &s.receiver;
        let value = f64::from(got[(s.pixel[1] * SIZE[0] + s.pixel[0]) as usize]);
        assert!((0.0..=1.0).contains(&value), "{value}");
        let levels = [r.squared, r.squared - r.room, r.squared + r.room];
        let levels = levels.map(|squared| serving(&entries, s, level(&record, squared)));
        let want = endless.visibility(s, levels[0], DVec2::ZERO, DVec2::ZERO);
        if endless.partial(s, levels[0]) {
            partial += 1;
            let texel = endless.texel(s, levels[0]);
            pages.insert((levels[0], (texel / endless.interior()).floor().as_i64vec2().to_array()));
            let inside = texel - (texel / endless.interior()).floor() * endless.interior();
            let reach = f64::from(filter.reach());
            across += usize::from(inside.min_element() < reach || inside.max_element() > endless.interior() - reach);
        }
        if (value - want).abs() <= 1e-3 {
            continue;
        }
        moved += 1;
        let all = levels.into_iter().flat_map(|level| {
            let endless = &endless;
            corners.into_iter().flat_map(move |a| corners.map(|b| endless.visibility(s, level, a, b)))
        });
        let (low, high) = all.fold((f64::INFINITY, 0.0f64), |(low, high), v| (low.min(v), high.max(v)));
        assert!(
            (low - 1e-3..=high + 1e-3).contains(&value),
            "{light:?}, {filter:?}: {value} at {:?}, not {want} ({low} to {high}), level {levels:?}",
            s.pixel
        );
    }
    println!("{filter:?}: {partial} partial of {}, {moved} by rounding, {across} across borders", samples.len());
    assert!(partial > 80 && across >= 4 && pages.len() >= 6, "{partial} {across} {}", pages.len());
    assert!(moved * 5 < partial, "{moved} of {partial}");
}

/// The same with levels blended: each sample is the mix of two levels that its footprint asks for, and neighbours on both sides of
/// a change of level differ by no more than those of one level do.
fn levels_leave_no_trace(light: &Light, filter: Filter) {
    let (scene, mut view) = scenes::sheet_over_floor(SIZE);
    view.lights = vec![light.clone()];
    let lab = Bench::new(scene, view);
    let config = Config { level_blend: true, ..config(filter) };
    let (got, table) = image(&lab, &config);
    let (plain, _) = image(&lab, &Config { level_blend: false, ..config.clone() });
    let (record, samples) = samples(&lab, &config, |height| height.abs() < 1e-3);
    let endless = Endless { light: record, origin: lab.scene().origin, eye: lab.view().camera.eye, config: &config };
    let entries: BTreeMap<u64, u32> =
        table.keys.iter().copied().zip(table.entries.iter().copied()).filter(|e| e.0 != 0).collect();
    let mixed = |s: &Sample, squared: f32, a: DVec2, b: DVec2| {
        let (level, weight) = blend(&record, squared);
        let seen = |level| endless.visibility(s, serving(&entries, s, level), a, b);
        let fine = seen(level);
        if weight > 0.0 { fine + weight * (seen(level + 1) - fine) } else { fine }
    };
    let corners = [[0.0, 0.0], [-NEAR, -NEAR], [NEAR, -NEAR], [-NEAR, NEAR], [NEAR, NEAR]].map(DVec2::from);
    let at = |s: &Sample| (s.pixel[1] * SIZE[0] + s.pixel[0]) as usize;
    let (mut blended, mut moved, mut apart) = (0, 0, 0);
    for s in &samples {
        let r = &s.receiver;
        let value = f64::from(got[at(s)]);
        let want = mixed(s, r.squared, DVec2::ZERO, DVec2::ZERO);
        let (level, weight) = blend(&record, r.squared);
        let fine = endless.visibility(s, serving(&entries, s, level), DVec2::ZERO, DVec2::ZERO);
        blended += usize::from(weight > 0.05 && (want - fine).abs() > 0.01);
        apart += usize::from((f64::from(plain[at(s)]) - want).abs() > 0.01);
        if (value - want).abs() <= 1e-3 {
            continue;
        }
        moved += 1;
        let all = [r.squared, r.squared - r.room, r.squared + r.room].into_iter().flat_map(|squared| {
            let mixed = &mixed;
            corners.into_iter().flat_map(move |a| corners.map(|b| mixed(s, squared, a, b)))
        });
        let (low, high) = all.fold((f64::INFINITY, 0.0f64), |(low, high), v| (low.min(v), high.max(v)));
        assert!(
            (low - 2e-3..=high + 2e-3).contains(&value),
            "{light:?}, {filter:?}: {value} at {:?}, not {want} ({low} to {high}), level {level} and {weight}",
            s.pixel
        );
    }
    // steps between neighbours on the two sides of a change of level, beyond what the moves within either level explain
    let by_pixel: BTreeMap<[u32; 2], &Sample> = samples.iter().map(|s| (s.pixel, s)).collect();
    let (mut changes, mut with, mut without) = (0, 0.0f64, 0.0f64);
    for s in &samples {
        for next in [[s.pixel[0] + 1, s.pixel[1]], [s.pixel[0], s.pixel[1] + 1]] {
            let Some(t) = by_pixel.get(&next) else { continue };
            let [(a, from), (b, to)] = [s, t].map(|s| blend(&record, s.receiver.squared));
            if a.abs_diff(b) != 1 || s.receiver.face != t.receiver.face {
                continue;
            }
            let levels = a.min(b)..=(a.max(b) + 1).min(ROOT_LEVEL);
            let seen = |s: &Sample, level| endless.visibility(s, serving(&entries, s, level), DVec2::ZERO, DVec2::ZERO);
            let pairs: Vec<(f64, f64)> = levels.map(|level| (seen(s, level), seen(t, level))).collect();
            let own = pairs.iter().map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            let between = pairs.windows(2).map(|w| (w[0].0 - w[1].0).abs().max((w[0].1 - w[1].1).abs()));
            let share = ((f64::from(a) + from) - (f64::from(b) + to)).abs();
            let explained = own + share * between.fold(0.0, f64::max);
            let beyond = |image: &[f32]| (f64::from(image[at(s)] - image[at(t)]).abs() - explained).max(0.0);
            changes += 1;
            with = with.max(beyond(&got));
            without = without.max(beyond(&plain));
        }
    }
    println!(
        "{filter:?}: {blended} blended, {moved} by rounding, {changes} changes: steps {with:.3}, {without:.3} without"
    );
    assert!(blended > 30 && apart > 30 && changes > 100, "{blended} {apart} {changes}");
    assert!(moved * 5 < apart, "{moved} of {apart}");
    // an edge of a tap may fall between neighbours that rounding moves
    assert!(with < 0.03 && without > 0.04, "{light:?}, {filter:?}: steps of {with}, {without} without blending");
}

#[test]
fn levels_blend_as_by_their_twin() {
    for light in lights() {
        for filter in kinds(4) {
            levels_leave_no_trace(&light, filter);
        }
    }
}

#[test]
fn kernels_cross_pages_of_a_directional_light_without_a_trace() {
    for filter in [Filter::Hard].into_iter().chain(kinds(9)).chain(kinds(4)) {
        pages_leave_no_trace(&lights()[0], filter);
    }
}

#[test]
fn kernels_cross_pages_of_a_spot_light_without_a_trace() {
    for filter in [Filter::Hard].into_iter().chain(kinds(9)).chain(kinds(3)) {
        pages_leave_no_trace(&lights()[1], filter);
    }
}

#[test]
fn kernels_cross_pages_of_a_point_light_without_a_trace() {
    for filter in [Filter::Hard].into_iter().chain(kinds(9)).chain(kinds(2)) {
        pages_leave_no_trace(&lights()[2], filter);
    }
}

/// Pixels that are neither lit nor shadowed: as many as the kernel is wide, but for a texel; none without a filter.
#[test]
fn edges_widen_with_the_kernel() {
    let (scene, view) = scenes::sheet_over_floor(SIZE);
    let lab = Bench::new(scene, view);
    let partial = |values: &[f32]| {
        assert!(values.iter().all(|v| (0.0..=1.0).contains(v)));
        values.iter().filter(|&&v| v > 0.0 && v < 1.0).count() as f64
    };
    assert_eq!(partial(&image(&lab, &config(Filter::Hard)).0), 0.0);
    for kind in 0..3 {
        // one gutter for all, so that levels and pages are the same
        let count = |taps| partial(&image(&lab, &Config { gutter: 5, ..config(kinds(taps)[kind]) }).0);
        let (two, four, eight) = (count(2), count(4), count(8));
        println!("{:?}: {two} {four} {eight}", kinds(2)[kind]);
        assert!(two > 80.0 && four > 1.4 * two && eight > 1.6 * four && eight < 2.5 * four, "{two} {four} {eight}");
    }
}

/// What `uniform` with keys makes of the first light.
fn map(lab: &Bench, keys: &str) -> Vec<f32> {
    let mut method = create(&MethodSpec::parse(&format!("uniform:resolution=1024,{keys}")).unwrap(), lab).unwrap();
    method.frame(lab).unwrap();
    method.visibility(lab, 0).unwrap()
}

#[test]
fn edges_of_maps_widen_with_the_kernel() {
    let (scene, view) = scenes::sheet_over_floor(SIZE);
    let lab = Bench::new(scene, view);
    for kind in ["pcf", "poisson", "bilinear"] {
        let count = |taps: u32| {
            let values = map(&lab, &format!("filter={kind},taps={taps}"));
            assert!(values.iter().all(|v| (0.0..=1.0).contains(v)));
            values.iter().filter(|&&v| v > 0.0 && v < 1.0).count() as f64
        };
        let (three, nine) = (count(3), count(9));
        println!("{kind}: {three} {nine}");
        assert!(three > 100.0 && nine > 2.0 * three && nine < 4.0 * three, "{kind}: {three} {nine}");
    }
}

/// Planes up to 84 degrees from facing the light.
#[test]
fn planes_do_not_shadow_themselves() {
    for rise in [0.0, 0.8, 2.5] {
        for light in [
            Light::directional(DVec3::new(0.8, -1.0, 0.3)),
            Light::directional(DVec3::new(-1.0, -0.45, -0.2)),
            spot([-2.5, 9.0, 1.0], [0.0, 0.0, 0.0], 50.0, 40.0),
            point([-1.5, 6.0, 1.5], 30.0),
        ] {
            let (scene, mut view) = scenes::slope(SIZE, rise);
            view.lights = vec![light];
            let lab = Bench::new(scene, view);
            let reached = |s: &Sample| s.receiver.margin > 0.1;
            for filter in kinds(9) {
                let blended = Config { level_blend: true, ..config(filter) };
                for config in [config(filter), blended] {
                    let (_, samples) = samples(&lab, &config, |_| true);
                    all_lit(
                        &format!("{config:?}"),
                        &lab,
                        &image(&lab, &config).0,
                        samples.iter().filter(|s| reached(s)),
                    );
                }
            }
            let (_, samples) = samples(&lab, &config(Filter::Hard), |_| true);
            for kind in ["pcf", "poisson", "bilinear"] {
                let keys = format!("filter={kind},taps=9");
                all_lit(&keys, &lab, &map(&lab, &keys), samples.iter().filter(|s| reached(s)));
            }
        }
    }
}

/// Fails for the first sample that is not wholly lit.
fn all_lit<'a>(case: &str, lab: &Bench, values: &[f32], samples: impl Iterator<Item = &'a Sample>) {
    for s in samples {
        let value = values[(s.pixel[1] * SIZE[0] + s.pixel[0]) as usize];
        assert_eq!(value, 1.0, "{case}, {:?}: {:?}, margin {}", lab.view().lights, s.pixel, s.receiver.margin);
    }
}
