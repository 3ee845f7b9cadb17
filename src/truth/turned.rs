//! Scene, samples and light in another place: what a second ray tracer would be given.

use super::GBuffer;
use crate::Light;
use crate::scene::{Instance, Scene};
use glam::{DMat3, DQuat, DVec3, Vec3};

/// Axis of the turn, of any length, and its angle in radians: no axis or diagonal of the scene maps to another one.
const AXIS: DVec3 = DVec3::new(0.36, 0.48, -0.8);
const ANGLE: f64 = 1.234_567;
/// Shift in diagonals of the scene's bounds.
const SHIFT: DVec3 = DVec3::new(2.31, -1.73, 3.17);

/// A fixed turn about the scene's origin, then a shift by some diagonals. It is applied in f64; positions, instances and
/// samples are stored in f32 again, so that nothing but their rounding changes.
pub(crate) struct Turned {
    turn: DMat3,
    shift: DVec3,
    origin: DVec3,
}

impl Turned {
    /// The turn and shift for a scene.
    pub(crate) fn new(scene: &Scene) -> Self {
        let turn = DMat3::from_quat(DQuat::from_axis_angle(AXIS.normalize(), ANGLE));
        Self { turn, shift: SHIFT * scene.diagonal(), origin: scene.origin }
    }

    /// What casts of the scene, turned and shifted. The bounds are those of `scene`, so that rays start as far from surfaces.
    pub(crate) fn scene(&self, scene: &Scene) -> Scene {
        let turned = |p: &[f32; 3]| self.direction(*p);
        Scene {
            positions: scene.positions.iter().map(turned).collect(),
            instances: scene.instances.iter().map(|instance| self.instance(instance)).collect(),
            ..scene.clone()
        }
    }

    /// The samples, turned and shifted.
    pub(crate) fn gbuffer(&self, gbuffer: &GBuffer) -> GBuffer {
        GBuffer {
            eye: self.turn * gbuffer.eye + self.shift,
            ray_steps: gbuffer.ray_steps.map(|step| self.turn * step),
            position: gbuffer.position.iter().map(|p| self.direction(*p)).collect(),
            normal: gbuffer.normal.iter().map(|n| self.direction(*n)).collect(),
            ..gbuffer.clone()
        }
    }

    /// The light, turned and shifted.
    pub(crate) fn light(&self, light: &Light) -> Light {
        let place = |p: DVec3| self.origin + self.turn * (p - self.origin) + self.shift;
        let mut light = light.clone();
        match &mut light {
            Light::Directional { direction, .. } => *direction = self.turn * *direction,
            Light::Spot { position, direction, .. } => {
                (*position, *direction) = (place(*position), self.turn * *direction);
            }
            Light::Point { position, .. } => *position = place(*position),
            Light::Area { polygon } => polygon.iter_mut().for_each(|p| *p = place(*p)),
        }
        light
    }

    fn direction(&self, v: [f32; 3]) -> [f32; 3] {
        (self.turn * Vec3::from_array(v).as_dvec3()).as_vec3().to_array()
    }

    /// Meshes are turned in their own space, so an instance first turns back.
    fn instance(&self, instance: &Instance) -> Instance {
        let rows = instance.rows.map(|r| r.map(f64::from));
        let column = |c: usize| DVec3::new(rows[0][c], rows[1][c], rows[2][c]);
        let linear = self.turn * DMat3::from_cols(column(0), column(1), column(2)) * self.turn.transpose();
        let row = |r: usize| linear.row(r).extend(0.0).as_vec4().to_array();
        let mut turned = Instance { rows: [row(0), row(1), row(2)], ..*instance };
        turned.set_translation(self.turn * instance.translation() + self.shift);
        turned
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_stays_where_it_was_relative_to_everything_else() {
        let scene = crate::scene::builtin();
        let turned = Turned::new(&scene);
        let other = turned.scene(&scene);
        let place = |scene: &Scene, instance: &Instance, vertex: usize| {
            let p = Vec3::from_array(scene.positions[vertex]).extend(1.0).as_dvec4();
            DVec3::from_array(instance.rows.map(|row| glam::Vec4::from_array(row).as_dvec4().dot(p)))
        };
        let eye = DVec3::new(3.0, 1.5, -4.0);
        let gbuffer = GBuffer { eye, position: vec![[1.0, -0.5, 0.25]], ..GBuffer::default() };
        let light = Light::Point { position: scene.origin + eye, range: 9.0 };
        let Light::Point { position: lamp, .. } = turned.light(&light) else { panic!("another light") };
        let moved = turned.gbuffer(&gbuffer);
        assert!((lamp - other.origin - moved.eye).length() < 1e-9 * scene.diagonal(), "{lamp} {}", moved.eye);
        let (sample, moved) = (gbuffer.point(0), moved.point(0));
        let mut rounded = 0;
        for mesh in &scene.meshes {
            let i = mesh.first_instance as usize;
            let vertex = scene.indices[mesh.first_index as usize] as usize;
            let before = place(&scene, &scene.instances[i], vertex) - sample;
            let after = place(&other, &other.instances[i], vertex) - moved;
            assert!((before.length() - after.length()).abs() < 2e-6 * scene.diagonal());
            assert!((after - turned.turn * before).length() < 2e-6 * scene.diagonal());
            rounded += u32::from(before.length() != after.length());
        }
        assert!(rounded > 0 && (scene.diagonal() - other.diagonal()).abs() < 1e-12);
    }
}
