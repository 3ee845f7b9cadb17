//! Copies of a scene side by side: more of the same, to see what a cost grows with.

use super::Scene;
use glam::DVec3;

/// Most copies.
pub const MAX_COPIES: u32 = 64;

/// Puts `copies` of a scene (1 to [`MAX_COPIES`]) on a square grid in x and z, as far apart as the scene is large. The first
/// stays where it is and the others surround it. Geometry is shared; the origin stays, the bounds grow.
pub fn repeated(mut scene: Scene, copies: u32) -> Scene {
    let copies = copies.clamp(1, MAX_COPIES);
    let side = f64::from(copies).sqrt().ceil() as u32;
    let middle = (side - 1) / 2;
    let pitch = scene.bounds_max - scene.bounds_min;
    // the first cell is the middle one
    let order = (0..side * side).map(|i| (i + middle * side + middle) % (side * side)).take(copies as usize);
    let steps = order.map(|cell| [cell % side, cell / side].map(|c| f64::from(c) - f64::from(middle)));
    let offsets: Vec<DVec3> = steps.map(|[x, z]| DVec3::new(x * pitch.x, 0.0, z * pitch.z)).collect();
    let once = std::mem::take(&mut scene.instances);
    for mesh in &mut scene.meshes {
        let placed = &once[mesh.first_instance as usize..][..mesh.instance_count as usize];
        mesh.first_instance = scene.instances.len() as u32;
        mesh.instance_count *= copies;
        for offset in &offsets {
            scene.instances.extend(placed.iter().map(|instance| {
                let mut copy = *instance;
                copy.set_translation(copy.translation() + *offset);
                copy
            }));
        }
    }
    let (low, high) = (scene.bounds_min, scene.bounds_max);
    for offset in offsets {
        scene.bounds_min = scene.bounds_min.min(low + offset);
        scene.bounds_max = scene.bounds_max.max(high + offset);
    }
    scene
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_are_placed_side_by_side() {
        let once = super::super::builtin();
        let four = repeated(once.clone(), 4);
        assert_eq!(four.drawn_triangles(), 4 * once.drawn_triangles());
        assert_eq!((four.instances.len(), four.origin), (4 * once.instances.len(), once.origin));
        let (size, grown) = (once.bounds_max - once.bounds_min, four.bounds_max - four.bounds_min);
        assert!((grown - size * DVec3::new(2.0, 1.0, 2.0)).length() < 1e-9 * size.length(), "{grown}, once {size}");
        let (a, b) = (&once.meshes[1], &four.meshes[1]);
        let first = four.instances[b.first_instance as usize];
        assert_eq!(first, once.instances[a.first_instance as usize], "the first copy stays in place");
        let places: std::collections::BTreeSet<[u32; 3]> = four.instances[b.first_instance as usize..]
            [..b.instance_count as usize]
            .iter()
            .map(|i| i.rows.map(|row| row[3].to_bits()))
            .collect();
        assert_eq!(places.len() as u32, b.instance_count);
    }

    #[test]
    fn one_copy_is_the_scene() {
        let once = super::super::builtin();
        let same = repeated(once.clone(), 1);
        assert_eq!((&same.instances, &same.meshes), (&once.instances, &once.meshes));
        assert_eq!((same.bounds_min, same.bounds_max), (once.bounds_min, once.bounds_max));
    }
}
