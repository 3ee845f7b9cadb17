//! A lab that fails the test on any message of the validation layers, and numbers that replay.

use glam::DVec3;
use std::ops::{Deref, DerefMut};
use umbrage::lab::{Lab, LabOptions, View};
use umbrage::scene::Scene;
use umbrage::{Camera, Light};

/// A lab under validation; dropping it checks that nothing was reported.
pub struct Bench(Lab);

impl Bench {
    pub fn new(scene: Scene, view: View) -> Self {
        Self(lab(scene, view))
    }

    /// For stages that bring their own input.
    pub fn plain() -> Self {
        let (scene, view) = super::scenes::sphere_on_plane([64, 48]);
        Self::new(scene, view)
    }
}

/// A lab whose messages nobody checks.
pub fn lab(scene: Scene, view: View) -> Lab {
    Lab::new(&LabOptions { device: None, validation: true }, scene, view)
        .expect("a Vulkan device with validation layers")
}

impl Deref for Bench {
    type Target = Lab;
    fn deref(&self) -> &Lab {
        &self.0
    }
}

impl DerefMut for Bench {
    fn deref_mut(&mut self) -> &mut Lab {
        &mut self.0
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        let messages = self.0.validation_messages();
        if !std::thread::panicking() {
            assert!(messages.is_empty(), "validation: {messages:#?}");
        }
    }
}

pub fn view(eye: [f64; 3], target: [f64; 3], direction: [f64; 3], size: [u32; 2]) -> View {
    let camera =
        Camera { eye: eye.into(), target: target.into(), up: DVec3::Y, fov_y_deg: 50.0, near: 0.02, far: 200.0 };
    View { camera, lights: vec![Light::directional(direction.into())], size, time_s: 0.0 }
}

/// Numbers from a seed (Knuth's MMIX generator, upper half).
pub struct Lcg(pub u64);

impl Lcg {
    pub fn word(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 32) as u32
    }

    /// Below `end`.
    pub fn below(&mut self, end: u32) -> u32 {
        ((u64::from(self.word()) * u64::from(end)) >> 32) as u32
    }

    /// From 0 to below 1.
    pub fn unit(&mut self) -> f64 {
        f64::from(self.word()) / 4_294_967_296.0
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}
