//! Scenes that move: every pose against a load at that time, what is reported as changed, bounds that hold at all
//! times, synthetic movers, and the lab's upload under validation.
#![cfg(feature = "lab")]

#[path = "scene/builder.rs"]
#[allow(dead_code)] // the other tests use the rest
mod builder;
#[path = "motion/docs.rs"]
mod docs;
#[path = "motion/lab.rs"]
mod lab;
#[path = "motion/synthetic.rs"]
mod synthetic;

use builder::{Doc, Folder, Random};
use docs::{animate, deforming, everything, grid, morphing, rigid, skinned};
use glam::{DVec3, Vec3, Vec4};
use serde_json::json;
use umbrage::scene::{self, LoadOptions, Motion, Scene, mesh_bounds};

fn at(time_s: f64) -> LoadOptions {
    LoadOptions { time_s, ..LoadOptions::default() }
}

fn moving(doc: &Doc, time_s: f64) -> (Scene, Motion) {
    let folder = Folder::new();
    let (scene, motion) = scene::load_moving(&folder.file("test.glb", &doc.glb()), &at(time_s)).unwrap();
    (scene, motion.unwrap())
}

fn still(doc: &Doc, time_s: f64) -> Scene {
    let folder = Folder::new();
    scene::load(&folder.file("test.glb", &doc.glb()), &at(time_s)).unwrap()
}

/// All triangles with an area, in world space.
fn world(scene: &Scene) -> Vec<[DVec3; 3]> {
    let mut out = Vec::new();
    for instance in &scene.instances {
        let mesh = scene.meshes[instance.mesh as usize];
        let place = |i: u32| {
            let p = Vec3::from(scene.positions[i as usize]).extend(1.0);
            scene.origin + Vec3::from(instance.rows.map(|r| Vec4::from(r).dot(p))).as_dvec3()
        };
        let indices = &scene.indices[mesh.first_index as usize..][..mesh.index_count as usize];
        out.extend(indices.chunks(3).map(|t| [place(t[0]), place(t[1]), place(t[2])]));
    }
    let area = |[a, b, c]: &[DVec3; 3]| (b - a).cross(c - a).length();
    out.retain(|t| area(t) > 1e-12 * scene.diagonal().powi(2));
    out
}

/// Whether both scenes show the same triangles, within 1e-5 of their size; a set may not be empty.
fn same(a: &Scene, b: &Scene) -> Result<(), String> {
    let (left, mut right) = (world(a), world(b));
    if left.is_empty() || left.len() != right.len() {
        return Err(format!("{} and {} triangles", left.len(), right.len()));
    }
    let slack = 1e-5 * a.diagonal().max(b.diagonal());
    for triangle in left {
        let near = |other: &[DVec3; 3]| triangle.iter().zip(other).all(|(p, q)| (*p - *q).length() <= slack);
        match right.iter().position(near) {
            Some(found) => drop(right.swap_remove(found)),
            None => return Err(format!("{triangle:?} has no partner")),
        }
    }
    Ok(())
}

#[track_caller]
fn contained(scene: &Scene) {
    let slack = DVec3::splat(1e-6 * scene.diagonal());
    for p in world(scene).into_iter().flatten() {
        let inside = p.cmpge(scene.bounds_min - slack).all() && p.cmple(scene.bounds_max + slack).all();
        assert!(inside, "{p} is outside {} {}", scene.bounds_min, scene.bounds_max);
    }
    for mesh in &scene.meshes {
        let (center, extent) = mesh_bounds(scene, mesh);
        for c in &scene.clusters[mesh.first_cluster as usize..][..mesh.cluster_count as usize] {
            for &i in &scene.indices[c.first_index as usize..][..c.triangle_count as usize * 3] {
                for axis in 0..3 {
                    let v = f64::from(scene.positions[i as usize][axis]);
                    let off = |center: f32| (v - f64::from(center)).abs();
                    assert!(off(c.center[axis]) <= f64::from(c.extent[axis]), "cluster");
                    assert!(off(center[axis]) <= f64::from(extent[axis]), "mesh");
                }
            }
        }
    }
}

#[test]
fn a_pose_is_what_a_load_shows() {
    for (name, doc) in [("rigid", rigid()), ("skin", skinned()), ("morph", morphing()), ("all", everything())] {
        let (mut scene, motion) = moving(&doc, 0.0);
        assert!((scene.origin - 0.5 * (scene.bounds_min + scene.bounds_max)).length() < 1e-9, "{name}");
        let mut start = scene.clone();
        for time in [0.5, 1.0, 0.0, 1.75, 2.0, 2.5, -0.4] {
            motion.pose(&mut scene, time).unwrap();
            same(&scene, &still(&doc, time)).unwrap_or_else(|e| panic!("{name} at {time}: {e}"));
        }
        // the same scene again, bit for bit but for revisions
        motion.pose(&mut scene, 0.0).unwrap();
        start.instances.iter_mut().zip(&scene.instances).for_each(|(a, b)| a.revision = b.revision);
        assert_eq!((&scene.positions, &scene.clusters), (&start.positions, &start.clusters), "{name}");
        assert_eq!(scene.instances, start.instances, "{name}");
        motion.pose(&mut scene, 0.5).unwrap();
        assert!(same(&scene, &still(&doc, 1.0)).is_err(), "{name}: nothing moves, so this shows nothing");
    }
}

#[test]
fn bounds_hold_at_all_times() {
    for doc in [rigid(), skinned(), morphing(), everything()] {
        let (mut scene, motion) = moving(&doc, 0.3);
        let (origin, low, high) = (scene.origin, scene.bounds_min, scene.bounds_max);
        contained(&scene);
        let mut random = Random(7);
        for _ in 0..200 {
            motion.pose(&mut scene, 4.0 * f64::from(random.unit()) - 1.0).unwrap();
            contained(&scene);
        }
        assert_eq!((scene.origin, scene.bounds_min, scene.bounds_max), (origin, low, high));
    }
}

#[test]
fn only_what_changed_is_reported() {
    let (mut scene, motion) = moving(&everything(), 0.0);
    assert!(motion.pose(&mut scene, 0.0).unwrap().is_empty());
    assert!(scene.instances.iter().all(|i| i.revision == 0));
    let before = scene.clone();
    let changes = motion.pose(&mut scene, 0.8).unwrap();
    let mut kinds = [0; 2];
    for (i, (old, new)) in before.instances.iter().zip(&scene.instances).enumerate() {
        let deformed = changes.meshes.contains(&new.mesh);
        let changed = old.rows != new.rows || deformed;
        kinds[usize::from(changed)] += 1;
        assert_eq!(changes.instances.contains(&(i as u32)), changed);
        assert_eq!(new.revision, u32::from(changed));
    }
    assert!(kinds[0] > 2 && kinds[1] > 2, "{kinds:?}");
    let covers = |runs: &[std::ops::Range<u32>], i: usize| runs.iter().any(|r| r.contains(&(i as u32)));
    for i in (0..scene.positions.len()).filter(|&i| scene.positions[i] != before.positions[i]) {
        assert!(covers(&changes.vertices, i), "vertex {i}");
    }
    for i in (0..scene.clusters.len()).filter(|&i| scene.clusters[i] != before.clusters[i]) {
        assert!(covers(&changes.clusters, i), "cluster {i}");
    }
    let reported: usize = changes.vertices.iter().map(|r| r.len()).sum();
    assert!(reported > 0 && reported < scene.positions.len(), "{reported} of {}", scene.positions.len());
    assert!(motion.pose(&mut scene, 0.8).unwrap().is_empty());
    // a revision wraps around
    let moved = changes.instances[0] as usize;
    scene.instances[moved].revision = u32::MAX;
    motion.pose(&mut scene, 0.1).unwrap();
    assert_eq!(scene.instances[moved].revision, 0);
}

#[test]
fn a_vertex_run_covers_the_moved_end_only() {
    // only the right half of a wide grid is weighted to the joint that moves
    let (mut scene, motion) = moving(&skinned(), 0.0);
    let changes = motion.pose(&mut scene, 0.5).unwrap();
    let reported: usize = changes.vertices.iter().map(|r| r.len()).sum();
    assert!(reported * 4 < scene.positions.len() * 3, "{reported} of {}", scene.positions.len());
}

#[test]
fn triangles_without_area_at_the_start_stay() {
    let mut doc = Doc::triangle();
    let deltas = doc.floats("VEC3", &[0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    doc.primitive()["targets"] = json!([{"POSITION": deltas}]);
    grid(&mut doc, 2, [5.0, 0.0, 0.0]);
    animate(&mut doc, 0, "weights", &[0.0, 1.0], "SCALAR", &[1.0, 0.0]);
    assert_eq!(still(&doc, 0.0).unique_triangles(), 8);
    let (mut scene, motion) = moving(&doc, 0.0);
    assert_eq!((scene.unique_triangles(), scene.warnings.len()), (9, 0));
    motion.pose(&mut scene, 0.75).unwrap();
    same(&scene, &still(&doc, 0.75)).unwrap();
}

#[test]
fn an_instance_may_start_at_scale_zero() {
    let mut doc = Doc::triangle();
    doc.push("nodes", json!({"mesh": 0, "translation": [3, 0, 0]}));
    animate(&mut doc, 0, "scale", &[0.0, 1.0], "VEC3", &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
    let (mut scene, motion) = moving(&doc, 0.0);
    assert_eq!(scene.instances.len(), 2);
    motion.pose(&mut scene, 1.0).unwrap();
    same(&scene, &still(&doc, 1.0)).unwrap();
}

#[test]
fn files_without_motion() {
    let mut doc = Doc::triangle();
    let folder = Folder::new();
    let load = |doc: &Doc| scene::load_moving(&folder.file("test.glb", &doc.glb()), &at(0.0)).unwrap();
    let (scene, motion) = load(&doc);
    assert!(motion.is_none());
    same(&scene, &still(&doc, 0.0)).unwrap();
    // the animation moves a node that shows nothing
    doc.push("nodes", json!({}));
    animate(&mut doc, 1, "translation", &[0.0, 1.0], "VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    assert!(load(&doc).1.is_none());
}

#[test]
fn wrong_times_and_scenes_are_refused() {
    let (mut scene, motion) = moving(&everything(), 0.0);
    let before = scene.clone();
    for time in [f64::NAN, f64::INFINITY] {
        let error = motion.pose(&mut scene, time).unwrap_err();
        assert!(error.what.contains("it must be finite") && error.path.contains("test.glb"), "{error}");
    }
    assert_eq!((scene.instances, scene.positions), (before.instances, before.positions));
    let error = motion.pose(&mut scene::builtin(), 0.0).unwrap_err();
    assert!(error.what.contains("another scene"), "{error}");
    let folder = Folder::new();
    assert!(scene::load_moving(&folder.file("test.glb", &deforming().glb()), &at(f64::NAN)).is_err());
}

#[test]
fn damaged_files_do_not_panic() {
    let bytes = everything().glb();
    let folder = Folder::new();
    let mut posed = 0;
    for seed in 0..1500 {
        let mut random = Random(seed);
        let mut damaged = bytes.clone();
        let text = u32::from_le_bytes(damaged[12..16].try_into().unwrap()) as usize;
        for _ in 0..=random.below(3) {
            // every second one in the JSON or the first values: keys, joints and weights
            let end = if seed % 2 == 0 { text } else { damaged.len() };
            let at = random.below(end);
            damaged[at] ^= 1 << random.below(8);
        }
        let loaded = scene::load_moving(&folder.file("damaged.glb", &damaged), &at(0.3));
        if let Ok((mut scene, Some(motion))) = loaded
            && motion.pose(&mut scene, 1.1).is_ok()
        {
            assert!(scene.positions.as_flattened().iter().all(|v| v.is_finite()));
            posed += 1;
        }
    }
    assert!((100..1400).contains(&posed), "{posed} of 1500 posed");
}
