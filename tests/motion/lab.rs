//! What the lab shows after its scene moved, against a fresh lab; any message of the validation layers fails.

use crate::docs::{everything, grid};
use crate::{moving, still};
use glam::DVec3;
use std::rc::Rc;
use umbrage::lab::{Lab, LabError, LabOptions, View};
use umbrage::methods::{self, MethodSpec};
use umbrage::scene::{Motion, Scene, builtin};
use umbrage::truth::GBuffer;
use umbrage::{Camera, Light};

const SIZE: [u32; 2] = [160, 120];

fn view() -> View {
    let (eye, target) = (DVec3::new(3.0, 3.0, 7.0), DVec3::new(1.0, 0.5, 0.0));
    let camera = Camera { eye, target, up: DVec3::Y, fov_y_deg: 60.0, near: 0.02, far: 200.0 };
    let light = Light::directional(DVec3::new(0.4, -0.7, -0.9));
    View { camera, lights: vec![light], size: SIZE, time_s: 0.0 }
}

fn open(scene: Scene, view: View) -> Lab {
    Lab::new(&LabOptions { device: None, validation: true }, scene, view)
        .expect("a Vulkan device with validation layers")
}

#[track_caller]
fn silent(lab: &Lab) {
    let messages = lab.validation_messages();
    assert!(messages.is_empty(), "validation: {messages:#?}");
}

fn visibility(lab: &Lab) -> Vec<f32> {
    let spec = MethodSpec::parse("rmsm:atlas_mib=16").unwrap();
    let mut method = methods::create(&spec, lab).unwrap();
    method.frame(lab).unwrap();
    method.visibility(lab, 0).unwrap()
}

/// Bit for bit, and neither empty nor full.
#[track_caller]
fn equal(a: &GBuffer, b: &GBuffer) {
    let hits = a.hit.iter().filter(|h| **h).count();
    assert!(hits > 500 && hits < a.hit.len(), "{hits} hits");
    assert!(a.hit == b.hit && a.position == b.position && a.normal == b.normal);
}

#[test]
fn an_animated_lab_shows_what_a_fresh_one_does() {
    let mut doc = everything();
    grid(&mut doc, 1, [0.0, 0.0, -2.0]);
    let (scene, motion) = moving(&doc, 0.0);
    let mut lab = open(scene, view());
    lab.set_motion(motion);
    let start = lab.gbuffer().unwrap();
    let dark = lab.reference(0, &|_| {}).unwrap();
    for time in [0.7, 1.6] {
        lab.animate(time).unwrap();
        assert_eq!(lab.view().time_s, time);
        let now = lab.gbuffer().unwrap();
        assert!(now.position != start.position && !Rc::ptr_eq(&now, &start));
        assert!(!Rc::ptr_eq(&lab.reference(0, &|_| {}).unwrap(), &dark));
        let fresh = open(lab.scene().clone(), view());
        equal(&now, &fresh.gbuffer().unwrap());
        assert_eq!(lab.reference(0, &|_| {}).unwrap().visibility, fresh.reference(0, &|_| {}).unwrap().visibility);
        // needs bounds of clusters, too
        assert_eq!(visibility(&lab), visibility(&fresh));
        silent(&fresh);
        // the file loaded at that time has another origin, so single precision rounds differently
        let loaded = open(still(&doc, time), view());
        let other = loaded.gbuffer().unwrap();
        let mut differing = 0;
        for i in 0..now.hit.len() {
            let place = |g: &GBuffer, lab: &Lab| lab.scene().origin + g.point(i);
            let (p, q) = (place(&now, &lab), place(&other, &loaded));
            let (m, n) = (DVec3::from(now.normal[i].map(f64::from)), DVec3::from(other.normal[i].map(f64::from)));
            let apart =
                now.hit[i] != other.hit[i] || (now.hit[i] && ((p - q).length() > 1e-4 || (m - n).length() > 1e-3));
            differing += usize::from(apart);
        }
        // pixels on edges may fall to the other side
        assert!(differing * 1000 <= now.hit.len(), "{differing} pixels at {time}");
    }
    let kept = lab.gbuffer().unwrap();
    lab.animate(1.6).unwrap();
    assert!(Rc::ptr_eq(&kept, &lab.gbuffer().unwrap()), "nothing moved");
    silent(&lab);
}

#[test]
fn synthetic_movers_are_drawn() {
    let mut scene = builtin();
    let (eye, target) = (DVec3::new(9.0, 1.7, 9.5), DVec3::new(-2.0, 1.2, -1.5));
    let motion = Motion::synthetic(&mut scene, eye, target, 4, 3);
    let view = View { camera: Camera { eye, target, ..view().camera }, ..view() };
    let mut lab = open(scene, view.clone());
    lab.set_motion(motion);
    let start = lab.gbuffer().unwrap();
    lab.animate(1.1).unwrap();
    assert!(lab.gbuffer().unwrap().position != start.position);
    let fresh = open(lab.scene().clone(), view);
    equal(&lab.gbuffer().unwrap(), &fresh.gbuffer().unwrap());
    silent(&lab);
}

#[test]
fn look_changes_camera_and_lights() {
    let mut lab = open(builtin(), view());
    let start = lab.gbuffer().unwrap();
    let tracer = std::ptr::from_ref(lab.tracer());
    let mut other = view();
    other.camera.eye += DVec3::X;
    other.lights = vec![Light::directional(DVec3::new(-0.4, -0.7, -0.9)); 2];
    lab.look(other.clone()).unwrap();
    assert_eq!(lab.view(), &other);
    equal(&lab.gbuffer().unwrap(), &open(builtin(), other.clone()).gbuffer().unwrap());
    assert!(lab.gbuffer().unwrap().position != start.position);
    assert!(std::ptr::eq(tracer, lab.tracer()));
    for wrong in [View { size: [160, 121], ..other.clone() }, View { lights: Vec::new(), ..other.clone() }] {
        assert!(matches!(lab.look(wrong), Err(LabError::Usage(_))));
    }
    assert!(matches!(lab.animate(f64::NAN), Err(LabError::Usage(_))));
    assert_eq!(lab.view(), &other);
    lab.animate(2.5).unwrap();
    assert_eq!(lab.view().time_s, 2.5);
    silent(&lab);
}
