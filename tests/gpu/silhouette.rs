//! Silhouette maps: which edges are silhouettes, where points lie, straight edges against the plane through edge and light,
//! images against ray tracing, and the artefacts that the source names.

use crate::bench::{Bench, Lcg};
use crate::comparators::{mixed, same_image};
use crate::scenes;
use glam::{DVec2, DVec3};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use umbrage::Light;
use umbrage::gpu::structs::{Fit, MapLight};
use umbrage::lab::{Lab, View};
use umbrage::methods::{MethodSpec, SilhouetteStage, create};
use umbrage::scene::{LoadOptions, Scene, load};
use umbrage::truth::{Metrics, compare};

const SIZE: [u32; 2] = [320, 180];

fn stage(lab: &Lab, spec: &str) -> SilhouetteStage {
    let mut stage = SilhouetteStage::new(&MethodSpec::parse(spec).unwrap(), lab).unwrap();
    stage.method().frame(lab).unwrap();
    stage
}

fn draw(lab: &Lab, spec: &str) -> Vec<f32> {
    let mut method = create(&MethodSpec::parse(spec).unwrap(), lab).unwrap();
    method.frame(lab).unwrap();
    method.visibility(lab, 0).unwrap()
}

/// A vertex of an instance, relative to the scene's origin.
fn place(scene: &Scene, instance: usize, vertex: u32) -> DVec3 {
    let p = DVec3::from(scene.positions[vertex as usize].map(f64::from));
    let row = |row: [f32; 4]| p.dot(DVec3::new(row[0].into(), row[1].into(), row[2].into())) + f64::from(row[3]);
    DVec3::from(scene.instances[instance].rows.map(row))
}

/// Bits of a position, by which vertices in one place are one.
type Key = [u32; 3];

fn key(scene: &Scene, vertex: u32) -> Key {
    scene.positions[vertex as usize].map(|v| (v + 0.0).to_bits())
}

/// Silhouettes as instance and ends, and those that rounding may decide either way.
fn twin(scene: &Scene, light: &Light) -> [BTreeSet<(u32, Key, Key)>; 2] {
    let mut found = [BTreeSet::new(), BTreeSet::new()];
    for mesh in scene.meshes.iter().filter(|m| m.casts && !m.alpha_tested) {
        let indices = &scene.indices[mesh.first_index as usize..][..mesh.index_count as usize];
        let mut edges: BTreeMap<[Key; 2], Vec<[u32; 3]>> = BTreeMap::new();
        for triangle in indices.chunks_exact(3) {
            for i in 0..3 {
                let corners = [triangle[i], triangle[(i + 1) % 3], triangle[(i + 2) % 3]];
                let mut ends = [key(scene, corners[0]), key(scene, corners[1])];
                ends.sort_unstable();
                edges.entry(ends).or_default().push(corners);
            }
        }
        for instance in mesh.first_instance..mesh.first_instance + mesh.instance_count {
            for ([from, to], triangles) in &edges {
                // the plane through the edge and the light, with the first triangle's ends for all
                let at = |vertex| place(scene, instance as usize, vertex);
                let (a, b) = (at(triangles[0][0]), at(triangles[0][1]));
                let beam = match light {
                    Light::Directional { direction, .. } => direction.normalize(),
                    Light::Point { position, .. } | Light::Spot { position, .. } => a - (*position - scene.origin),
                    _ => unreachable!("no such light"),
                };
                let plane = (b - a).cross(beam).normalize();
                let sides = || triangles.iter().map(|t| plane.dot(at(t[2]) - a));
                let open = sides().all(|s| s > 0.0) || sides().all(|s| s < 0.0);
                // what single precision makes of coordinates that are as large as the scene
                if sides().any(|s| s.is_nan() || s.abs() < 1e-6 * scene.diagonal()) {
                    found[1].insert((instance, *from, *to));
                } else if open {
                    found[0].insert((instance, *from, *to));
                }
            }
        }
    }
    found
}

#[test]
fn silhouettes_are_those_of_the_twin() {
    let mut cases: Vec<_> = (0..6).map(|seed| scenes::random([64, 36], seed)).collect();
    cases.extend([scenes::closed([64, 36]), scenes::sphere_on_plane([64, 36]), scenes::street([64, 36])]);
    let inside = Light::Point { position: DVec3::new(0.3, 1.4, 0.2), range: 30.0 };
    let (scene, view) = scenes::room([64, 36]);
    cases.push((scene, View { lights: vec![inside], ..view }));
    for (scene, view) in cases {
        let name = format!("{}, {:?}", scene.name, view.lights[0]);
        let lab = Bench::new(scene, view);
        let stage = stage(&lab, "silhouette:resolution=64");
        let outlines = stage.silhouettes(&lab).unwrap();
        let scene = lab.scene();
        let got: BTreeSet<_> = outlines
            .iter()
            .map(|outline| {
                let mut ends = outline.ends.map(|vertex| key(scene, vertex));
                ends.sort_unstable();
                (outline.instance, ends[0], ends[1])
            })
            .collect();
        assert_eq!(got.len(), outlines.len(), "{name}: an edge is listed twice");
        let [want, either] = twin(scene, &lab.view().lights[0]);
        println!("{name}: {} silhouettes, {} either way", want.len(), either.len());
        assert!(want.len() > 20 && either.len() * 20 < want.len(), "{name}");
        let missing: Vec<_> = want.difference(&got).collect();
        let wrong: Vec<_> = got.difference(&want).filter(|edge| !either.contains(edge)).collect();
        assert!(missing.is_empty() && wrong.is_empty(), "{name}: missing {missing:?}, wrong {wrong:?}");
    }
}

/// Coordinates in the depth map of parallel light.
fn texel_of((light, fit): (&MapLight, &Fit), side: f64, p: DVec3) -> DVec2 {
    let dot = |row: [f32; 4], v: DVec3| v.dot(DVec3::new(row[0].into(), row[1].into(), row[2].into()));
    let from_eye = p - DVec3::new(light.eye[0].into(), light.eye[1].into(), light.eye[2].into());
    let face = &light.faces[0];
    let across = [face.x, face.y].map(|axis| dot(axis, from_eye) + f64::from(axis[3]));
    let t = DVec3::new(across[0], across[1], 1.0);
    side * DVec2::new(dot(fit.row_u, t), dot(fit.row_v, t))
}

fn distance(p: DVec2, [a, b]: [DVec2; 2]) -> f64 {
    let along = b - a;
    let t = if along.length() > 0.0 { ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0) } else { 0.0 };
    (a + t * along - p).length()
}

/// Each point lies on a silhouette; and along an edge that nothing hides every texel holds one.
#[test]
fn points_lie_on_silhouettes() {
    const SIDE: u32 = 128;
    let cases =
        [scenes::random(SIZE, 11), scenes::random(SIZE, 12), scenes::sheet_over_floor(SIZE), scenes::closed(SIZE)];
    for (scene, view) in cases {
        let lab = Bench::new(scene, view);
        let name = &lab.scene().name;
        let stage = stage(&lab, &format!("silhouette:resolution={SIDE}"));
        let (light, fits) = stage.place(&lab).unwrap();
        let map = |p: DVec3| texel_of((&light, &fits[0]), SIDE.into(), p) - 0.5;
        let ends: Vec<_> = stage
            .silhouettes(&lab)
            .unwrap()
            .iter()
            .map(|o| o.ends.map(|vertex| map(place(lab.scene(), o.instance as usize, vertex))))
            .collect();
        let points = stage.points(&lab).unwrap();
        let held = || points.iter().enumerate().filter_map(|(i, p)| Some((i as u32, (*p)?)));
        assert!(held().count() > 100, "{name}: {} points", held().count());
        for (i, [u, v]) in held() {
            assert!((0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v), "{name}: texel {i} holds {u}, {v}");
            let p = DVec2::new(f64::from(i % SIDE) + f64::from(u), f64::from(i / SIDE) + f64::from(v));
            let nearest = ends.iter().map(|&ends| distance(p, ends)).fold(f64::INFINITY, f64::min);
            // an enlarged texel's point is moved into the texel, by a 256th along each axis
            assert!(nearest < 0.01, "{name}: texel {i} holds a point {nearest} texels off every silhouette");
        }
        if name == "sheet" {
            let [from, to] = scenes::SHEET_EDGE.map(|p| map(DVec3::from(p) - lab.scene().origin));
            let steps = (to - from).length() as u32 * 8;
            let passed: BTreeSet<u32> = (0..=steps)
                .map(|i| from + (to - from) * (f64::from(i) / f64::from(steps)))
                .filter(|p| p.min_element() >= 0.0 && p.max_element() < f64::from(SIDE - 1))
                .map(|p| p.y as u32 * SIDE + p.x as u32)
                .collect();
            assert!(passed.len() > SIDE as usize / 2, "{passed:?}");
            let empty: Vec<_> = passed.iter().filter(|&&i| points[i as usize].is_none()).collect();
            assert!(empty.is_empty(), "the edge passes {empty:?}");
        }
    }
}

/// How far from the true border a wrong pixel of the floor lies at most, in texels.
fn farthest_error(lab: &Lab, visibility: &[f32], plane: (DVec3, f64), texel: f64) -> f64 {
    let g = lab.gbuffer().unwrap();
    let floor = -lab.scene().origin.y;
    let mut farthest = 0.0f64;
    let mut seen = 0;
    for (i, lit) in visibility.iter().enumerate() {
        let p = g.point(i);
        if !g.hit[i] || (p.y - floor).abs() > 1e-3 {
            continue;
        }
        seen += 1;
        let across = plane.0.dot(p) - plane.1;
        if (across > 0.0) != (*lit > 0.5) {
            farthest = farthest.max(across.abs() / texel);
        }
    }
    assert!(seen > 1000, "{seen} pixels of the floor");
    farthest
}

/// A straight edge at random angles and offsets is reconstructed as it is; staircases of a conventional map are not.
#[test]
fn straight_edges_are_exact() {
    let mut lcg = Lcg(20_031);
    for case in 0..8 {
        let (angle, offset) = (lcg.between(0.0, std::f64::consts::TAU), lcg.between(-0.6, 0.6));
        let (scene, view, edge) = scenes::half_plane(SIZE, angle, offset);
        let lab = Bench::new(scene, view);
        let Light::Directional { direction, .. } = &lab.view().lights[0] else { unreachable!() };
        let [from, to] = edge.map(|p| p - lab.scene().origin);
        // away from the sheet
        let normal = (to - from).cross(*direction).normalize();
        let normal = if normal.dot(scenes::half_plane_inwards(angle)) < 0.0 { normal } else { -normal };
        let stage = stage(&lab, "silhouette:resolution=64");
        let texel = stage.place(&lab).unwrap().1[0].texel;
        let texel = f64::from(texel[0].min(texel[1]));
        let error = |spec: &str| farthest_error(&lab, &draw(&lab, spec), (normal, normal.dot(from)), texel);
        let [own, conventional] = ["silhouette:resolution=64", "uniform:resolution=64"].map(error);
        println!("case {case}, angle {angle:.3}, offset {offset:.3}: {own:.4} texels, conventional {conventional:.3}");
        assert!(own < 0.02, "case {case}: {own} texels off");
        assert!(conventional > 0.2, "case {case}: a conventional map is {conventional} texels off");
    }
}

fn errs(lab: &Lab, spec: &str) -> Metrics {
    let reference = lab.reference(0, &|_| {}).unwrap();
    let visibility = draw(lab, spec);
    mixed(&visibility).unwrap_or_else(|why| panic!("{spec}: {why}"));
    let m = compare(&visibility, &reference).unwrap();
    println!("{}, {spec}: mismatch {:.4} %, acne {:.4}, leak {:.4}", lab.scene().name, m.mismatch, m.acne, m.leak);
    m
}

/// Where bodies are wider than texels, a sixth of the errors is left at most; with lights of all kinds.
#[test]
fn images_match_the_reference() {
    let at = DVec3::new(-2.0, 4.0, 1.5);
    let spot = Light::Spot { position: at, direction: -at, inner_angle_deg: 0.0, outer_angle_deg: 50.0, range: 30.0 };
    for light in [None, Some(spot), Some(Light::Point { position: at, range: 30.0 })] {
        for (scene, mut view) in [scenes::sphere_on_plane(SIZE), scenes::closed(SIZE), scenes::awning(SIZE)] {
            view.lights = light.clone().map_or(view.lights, |light| vec![light]);
            let lab = Bench::new(scene, view);
            let [uniform, own] = ["uniform:resolution=96", "silhouette:resolution=96"].map(|spec| errs(&lab, spec));
            assert!(uniform.mismatch > 0.1, "{uniform:?}");
            assert!(6.0 * own.mismatch <= uniform.mismatch && own.off_edge < 0.05, "{own:?}, {uniform:?}");
        }
    }
}

/// The source's figure 7: silhouettes that meet in a texel, two that pass one without touching, and a corner that no depth sees.
#[test]
fn artefacts_of_the_source_are_there() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/silhouette/artefacts.gltf");
    let scene = load(&path, &LoadOptions::default()).unwrap();
    let mut view = scenes::sphere_on_plane([480, 360]).1;
    view.camera.fov_y_deg = 40.0;
    view.camera.eye = DVec3::new(0.2, 7.0, 3.2);
    view.camera.target = DVec3::new(0.2, 0.0, 0.25);
    view.lights = vec![Light::directional(DVec3::new(0.02, -1.0, 0.03))];
    let lab = Bench::new(scene, view);
    let reference = lab.reference(0, &|_| {}).unwrap();
    let g = lab.gbuffer().unwrap();
    let wrong = |spec: &str, x: [f64; 2], z: [f64; 2]| {
        let visibility = draw(&lab, spec);
        let within = |i: usize| {
            let p = g.point(i) + lab.scene().origin;
            (x[0]..x[1]).contains(&p.x) && (z[0]..z[1]).contains(&p.z)
        };
        let differs = |i: usize| reference.decided[i] && f32::from(reference.visibility[i]) != visibility[i];
        (0..visibility.len()).filter(|&i| within(i) && differs(i)).count()
    };
    // where they meet, along the gap, and at the tip; then along straight edges
    let artefacts = [
        ("meeting", [-2.4, -1.0], [-0.7, 1.3]),
        ("gap", [-0.2, 0.6], [-1.6, 2.0]),
        ("corner", [1.6, 2.4], [-1.8, -1.0]),
    ];
    for (name, x, z) in artefacts {
        let [conventional, own] = ["uniform:resolution=64", "silhouette:resolution=64"].map(|s| wrong(s, x, z));
        println!("{name}: {own} pixels, conventional {conventional}");
        assert!(own >= 3, "{name}: {own} wrong pixels");
        assert!(own <= conventional, "{name}: {own} wrong pixels, conventional {conventional}");
    }
    let straight = ([1.2, 2.6], [-0.7, 1.6]);
    let [conventional, own] =
        ["uniform:resolution=64", "silhouette:resolution=64"].map(|s| wrong(s, straight.0, straight.1));
    println!("straight: {own} pixels, conventional {conventional}");
    assert!(own * 20 <= conventional && conventional > 60, "straight: {own}, conventional {conventional}");
}

/// The list's order is that of the atomics; what texels hold is not.
#[test]
fn points_do_not_depend_on_the_order_of_edges() {
    let lab = Bench::new(scenes::street(SIZE).0, scenes::street(SIZE).1);
    let mut stage = stage(&lab, "silhouette:resolution=256");
    let (points, image) = (stage.points(&lab).unwrap(), stage.method().visibility(&lab, 0).unwrap());
    for _ in 0..6 {
        stage.method().frame(&lab).unwrap();
        assert!(stage.points(&lab).unwrap() == points);
        same_image(&image, &stage.method().visibility(&lab, 0).unwrap()).unwrap();
    }
    assert!(points.iter().flatten().count() > 1000);
}

/// What alpha cuts away has no silhouette in the geometry: leaves are as in a conventional map.
#[test]
fn alpha_tested_casters_are_conventional() {
    let (scene, view) = scenes::leaves(SIZE);
    let masked: BTreeSet<u32> = scene.meshes.iter().filter(|m| m.alpha_tested).map(|m| m.first_instance).collect();
    let lab = Bench::new(scene, view);
    let outlines = stage(&lab, "silhouette:resolution=512").silhouettes(&lab).unwrap();
    assert!(!outlines.is_empty() && outlines.iter().all(|o| !masked.contains(&o.instance)));
    let [uniform, own] = ["uniform:resolution=192", "silhouette:resolution=192"].map(|spec| errs(&lab, spec));
    assert!((own.mismatch / uniform.mismatch - 1.0).abs() < 0.15, "{own:?}, {uniform:?}");
}
