//! Partition by faces of the view frustum (Kozlov 2004; Lloyd et al. 2006; book, 4.3.2): a sample belongs to the face through which
//! the light's line through it leaves the frustum on the side where it is nearer to the eye. These are the faces that the light
//! enters where it shines along the view, and those that it leaves where it shines against it: of the two crossings of a line
//! the one that needs the smaller texels. The far face is never among them.

use super::map_light;
use super::warp_passes::Axis;
use crate::engine::constants::light_axes;
use crate::gpu::structs::Slices;
use crate::lab::{Lab, LabError};
use bytemuck::Zeroable;
use glam::{DVec2, DVec3};

/// The near face, then left, right, bottom and top.
pub(super) const FACES: usize = 5;

/// Of a frame: where lines leave, for shaders, and for each face that is not the near one the way in which it widens.
pub(super) fn faces(lab: &Lab) -> Result<(Slices, [Axis; FACES]), LabError> {
    let view = lab.view();
    let [x, y, light] = light_axes(map_light::direction(&view.lights[0]))?;
    let camera = view.camera.view_from_world();
    let tan = (0.5 * view.camera.fov_y_deg.to_radians()).tan();
    let tan = DVec2::new(tan * f64::from(view.size[0]) / f64::from(view.size[1]), tan);
    let (slices, axes) = of_frustum([camera.row(0), camera.row(1), -camera.row(2)], tan, light);
    Ok((
        slices,
        axes.map(|axis| axis.map_or(Axis::NONE, |axis| Axis::through_eye(DVec2::new(axis.dot(x), axis.dot(y))))),
    ))
}

/// `camera`: right, up and forward; `tan`: of half the angles that the frustum opens; `light`: unit vector of its travel. With
/// each face the gradient across the light of the depths on it; `None` for the near face, and where no line leaves.
fn of_frustum([right, up, forward]: [DVec3; 3], tan: DVec2, light: DVec3) -> (Slices, [Option<DVec3>; FACES]) {
    let way = if forward.dot(light) > 0.0 { -light } else { light };
    let mut slices = Slices::zeroed();
    let mut axes = [None; FACES];
    // lines across the view never reach the near face; what is on it stays its own
    slices.exits[0][3] = (1.0 / (-forward.dot(way)).max(1e-9)) as f32;
    let inwards = [right + tan.x * forward, -right + tan.x * forward, up + tan.y * forward, -up + tan.y * forward];
    for (i, inwards) in (1..).zip(inwards.map(DVec3::normalize)) {
        let speed = -inwards.dot(way);
        slices.exits[i] = if speed > 1e-9 {
            let plane = (inwards / speed).as_vec3();
            axes[i] = Some(forward - inwards * (forward.dot(light) / inwards.dot(light)));
            [plane.x, plane.y, plane.z, 0.0]
        } else {
            [0.0, 0.0, 0.0, 1e30]
        };
    }
    (slices, axes)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAMERA: [DVec3; 3] = [DVec3::X, DVec3::Y, DVec3::NEG_Z];

    /// The gradient tells the depth on a face from where the light's line through the eye is.
    #[test]
    fn gradients_are_those_of_the_depths_on_a_face() {
        let tan = DVec2::new(0.7, 0.4);
        let corner = |x: f64, y: f64| DVec3::new(x * tan.x, y * tan.y, -1.0);
        let edges = [(-1.0, -1.0, -1.0, 1.0), (1.0, -1.0, 1.0, 1.0), (-1.0, -1.0, 1.0, -1.0), (-1.0, 1.0, 1.0, 1.0)];
        for light in [DVec3::new(0.3, -1.0, -0.4), DVec3::new(0.2, 0.1, -1.0), DVec3::new(-1.0, -0.5, 0.6)] {
            let light = light.normalize();
            let (slices, axes) = of_frustum(CAMERA, tan, light);
            assert!(axes.iter().flatten().count() >= 2, "{light}: {axes:?}");
            for (i, (ax, ay, bx, by)) in (1..).zip(edges) {
                assert_eq!(axes[i].is_some(), slices.exits[i][3] == 0.0);
                let Some(axis) = axes[i] else { continue };
                assert!(axis.dot(light).abs() < 1e-9);
                for (a, b) in [(0.5, 3.0), (7.0, 0.0), (2.0, 2.0)] {
                    let on_face = corner(ax, ay) * a + corner(bx, by) * b;
                    assert!((axis.dot(on_face) - (a + b)).abs() < 1e-9, "{light}, face {i}");
                }
            }
        }
    }

    /// A frustum has two crossings of each line; the nearer ones lie on the near face and on up to four sides.
    #[test]
    fn lines_leave_through_the_faces_of_the_source() {
        let tan = DVec2::new(0.7, 0.4);
        let used = |light: DVec3| {
            let (slices, _) = of_frustum(CAMERA, tan, light.normalize());
            slices.exits[1..].iter().map(|e| u32::from(e[3] == 0.0)).sum::<u32>()
        };
        // with the near face: two and three of six from beside the frustum, five where the light shines along the view or against it
        for (light, sides) in [
            (DVec3::NEG_Y, 1),
            (DVec3::new(0.0, -1.0, -0.2), 3),
            (DVec3::new(1.0, -1.0, -0.2), 2),
            (DVec3::new(1.0, -1.0, 0.2), 2),
            (DVec3::new(0.1, -0.1, -1.0), 4),
            (DVec3::new(0.1, -0.1, 1.0), 4),
        ] {
            assert_eq!(used(light), sides, "{light}");
        }
    }
}
