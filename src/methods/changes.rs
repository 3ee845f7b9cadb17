//! What moved in a lab's scene from one frame to the next, for methods that keep something across frames.

use crate::lab::Lab;
use crate::scene::{Instance, Scene, mesh_bounds};
use glam::Vec3;

/// A box relative to the scene's origin: lower and upper corner.
pub(super) type Bounds = [Vec3; 2];

/// Remembers the scene's instances.
#[derive(Default)]
pub(super) struct Changes {
    instances: Vec<Instance>,
    bounds: Vec<Bounds>,
}

impl Changes {
    /// Where casters or receivers were or are now that changed since the last call; `None` in the first.
    pub(super) fn since(&mut self, lab: &Lab) -> Option<Vec<Bounds>> {
        let scene = lab.scene();
        if self.instances.len() != scene.instances.len() {
            self.instances = scene.instances.clone();
            self.bounds = scene.instances.iter().map(|i| bounds(scene, i)).collect();
            return None;
        }
        let mut moved = Vec::new();
        for ((old, old_bounds), new) in self.instances.iter_mut().zip(&mut self.bounds).zip(&scene.instances) {
            if bytemuck::bytes_of(old) != bytemuck::bytes_of(new) {
                moved.push(*old_bounds);
                (*old, *old_bounds) = (*new, bounds(scene, new));
                moved.push(*old_bounds);
            }
        }
        Some(moved)
    }
}

/// Of all clusters of an instance.
fn bounds(scene: &Scene, instance: &Instance) -> Bounds {
    let (center, extent) = mesh_bounds(scene, &scene.meshes[instance.mesh as usize]);
    let (center, extent) = (Vec3::from(center), Vec3::from(extent));
    let row = |row: [f32; 4]| {
        let axis = Vec3::new(row[0], row[1], row[2]);
        (axis.dot(center) + row[3], axis.abs().dot(extent))
    };
    let [x, y, z] = instance.rows.map(row);
    let (middle, reach) = (Vec3::new(x.0, y.0, z.0), Vec3::new(x.1, y.1, z.1));
    // rounding
    let reach = reach + 1e-5 * (middle.abs() + reach);
    [middle - reach, middle + reach]
}

/// No more than `most` boxes that hold all: neighbours in the list become one.
pub(super) fn merged(boxes: &[Bounds], most: usize) -> Vec<Bounds> {
    let join = |a: Bounds, b: &Bounds| [a[0].min(b[0]), a[1].max(b[1])];
    let chunk = boxes.len().div_ceil(most).max(1);
    boxes.chunks(chunk).map(|chunk| chunk.iter().skip(1).fold(chunk[0], join)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin;

    #[test]
    fn an_instance_lies_in_its_bounds() {
        let scene = builtin();
        for instance in &scene.instances {
            let [low, high] = bounds(&scene, instance);
            let mesh = &scene.meshes[instance.mesh as usize];
            for &i in &scene.indices[mesh.first_index as usize..][..mesh.index_count as usize] {
                let p = Vec3::from(scene.positions[i as usize]).extend(1.0);
                let world = Vec3::from(instance.rows.map(|row| glam::Vec4::from(row).dot(p)));
                assert!(world.cmpge(low).all() && world.cmple(high).all(), "{world} not in {low} to {high}");
            }
        }
    }

    #[test]
    fn merged_boxes_hold_all() {
        let boxes: Vec<Bounds> = (0..10).map(|i| [Vec3::splat(i as f32), Vec3::splat(i as f32 + 1.0)]).collect();
        assert_eq!(merged(&boxes, 64), boxes);
        assert_eq!(merged(&boxes, 3).len(), 3);
        assert_eq!(merged(&boxes, 1), [[Vec3::ZERO, Vec3::splat(10.0)]]);
        assert!(merged(&[], 3).is_empty());
    }
}
