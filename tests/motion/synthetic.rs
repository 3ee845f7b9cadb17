//! Movers for scenes that have none.

use crate::contained;
use glam::DVec3;
use umbrage::Camera;
use umbrage::scene::{Motion, builtin};

const EYE: DVec3 = DVec3::new(9.0, 1.7, 9.5);
const TARGET: DVec3 = DVec3::new(-2.0, 1.2, -1.5);

#[test]
fn movers_circle_in_view_and_in_bounds() {
    let before = builtin();
    let mut scene = before.clone();
    let motion = Motion::synthetic(&mut scene, EYE, TARGET, 12, 5);
    assert_eq!(scene.origin, before.origin);
    assert_eq!(scene.meshes.len(), before.meshes.len() + 1);
    let mesh = *scene.meshes.last().unwrap();
    assert_eq!((mesh.index_count, mesh.instance_count, mesh.casts, mesh.alpha_tested), (15_000, 12, true, false));
    let camera = Camera { eye: EYE, target: TARGET, up: DVec3::Y, fov_y_deg: 40.0, near: 0.02, far: 200.0 };
    let view = camera.view_from_world();
    let half = 20f64.to_radians().tan();
    let distance = (TARGET - EYE).length();
    let mut places = Vec::new();
    for step in 0..64 {
        let changes = motion.pose(&mut scene, 0.25 * f64::from(step)).unwrap();
        assert!(changes.vertices.is_empty() && changes.clusters.is_empty() && changes.meshes.is_empty());
        assert_eq!(changes.instances.len(), if step == 0 { 0 } else { 12 });
        contained(&scene);
        for instance in &scene.instances[mesh.first_instance as usize..] {
            let centre = scene.origin + DVec3::from(instance.rows.map(|r| f64::from(r[3])));
            let at = view * (centre - EYE);
            let room = 0.02 * distance;
            let reach = at.x.abs().max(at.y.abs()) + room * 1.1;
            assert!(reach < -at.z * half && -at.z < distance, "{at}");
            assert!(centre.y - room > TARGET.y, "{centre} at {step}");
            places.push(centre);
        }
    }
    // after four seconds all are back, but for the turn of the first, which stays where it is
    let after = |step: usize, i: usize| places[12 * step + i];
    for i in 0..12 {
        assert!((after(0, i) - after(16, i)).length() < 1e-4);
        assert_eq!((after(0, i) - after(8, i)).length() < 1e-4, i == 0);
    }
    motion.pose(&mut scene, 4.0).unwrap();
    let quarter = scene.instances[mesh.first_instance as usize].rows;
    motion.pose(&mut scene, 16.0).unwrap();
    assert_ne!(scene.instances[mesh.first_instance as usize].rows, quarter);
}

#[test]
fn the_same_seed_gives_the_same_movers() {
    let make = |seed| {
        let mut scene = builtin();
        Motion::synthetic(&mut scene, EYE, TARGET, 3, seed);
        scene.instances.split_off(scene.instances.len() - 3)
    };
    assert_eq!(make(1), make(1));
    assert_ne!(make(1), make(2));
}

#[test]
fn odd_arguments() {
    let before = builtin();
    let mut scene = before.clone();
    let motion = Motion::synthetic(&mut scene, EYE, TARGET, 0, 1);
    assert_eq!((scene.meshes.len(), scene.bounds_max), (before.meshes.len(), before.bounds_max));
    assert!(motion.pose(&mut scene, 1.0).unwrap().is_empty());
    for (eye, target) in [(EYE, EYE), (DVec3::NAN, TARGET), (DVec3::Y * 5.0, DVec3::ZERO), (DVec3::ZERO, DVec3::Y)] {
        let mut scene = before.clone();
        let motion = Motion::synthetic(&mut scene, eye, target, 2, 1);
        motion.pose(&mut scene, 1.3).unwrap();
        contained(&scene);
    }
}
