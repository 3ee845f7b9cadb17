//! Lights at random places of a scene, to measure many with.

use super::path::random;
use crate::Light;
use crate::lab::View;
use crate::scene::Scene;
use glam::DVec3;

/// Most lights that can be asked for.
pub const MAX_SYNTHETIC_LIGHTS: u32 = 1365;

/// Range of a light over the diagonal of the scene's bounds.
const RANGE: f64 = 0.06;

impl View {
    /// The view with `count` lights in place of its own, spots and points by turns. Each hangs above a vertex of an instance
    /// drawn at random, by a tenth to a half of its range, and up to a tenth of it aside along each axis, so that it lies in no
    /// wall's plane; spots shine down. The first n of more lights are the same.
    pub fn with_lights(self, scene: &Scene, count: u32, seed: u64) -> View {
        let range = RANGE * scene.diagonal();
        let lights = (0..count).map(|i| {
            let draw = |k: u64| random(!seed, 8 * u64::from(i) + k);
            let pick = |k: u64, n: usize| (((draw(k) + 0.5) * n as f64) as usize).min(n.saturating_sub(1));
            let away = DVec3::new(0.2 * draw(5), 0.3 + 0.4 * draw(2), 0.2 * draw(6));
            let position = vertex(scene, |n| pick(0, n), |n| pick(1, n)) + range * away;
            if i % 2 == 0 {
                let direction = DVec3::new(draw(3), -1.0, draw(4));
                Light::Spot { position, direction, inner_angle_deg: 30.0, outer_angle_deg: 50.0, range }
            } else {
                Light::Point { position, range }
            }
        });
        View { lights: lights.collect(), ..self }
    }
}

/// A vertex in world space; `instance` and `index` choose one of so many.
fn vertex(scene: &Scene, instance: impl Fn(usize) -> usize, index: impl Fn(usize) -> usize) -> DVec3 {
    let Some(instance) = scene.instances.get(instance(scene.instances.len())) else { return scene.origin };
    let mesh = &scene.meshes[instance.mesh as usize];
    let at = mesh.first_index as usize + index(mesh.index_count as usize);
    let p = DVec3::from(scene.positions[scene.indices[at] as usize].map(f64::from));
    let row = |r: [f32; 4]| DVec3::new(r[0].into(), r[1].into(), r[2].into()).dot(p) + f64::from(r[3]);
    scene.origin + DVec3::from(instance.rows.map(row))
}
