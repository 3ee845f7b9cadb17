//! The light of a map method as constants: axes of each layer, depth range and bias, computed in double precision.

use crate::Light;
use crate::engine::constants::light_axes;
use crate::gpu::structs::{Face, MapLight};
use crate::host::SceneBuffers;
use crate::lab::{Lab, LabError};
use bytemuck::Zeroable;
use glam::DVec3;
use std::fmt;

/// Widest angle from the axis, in degrees, at which one map serves a cone; wider cones are served as a cube.
const WIDEST_DEG: f64 = 60.0;
/// Near plane of lights with a position, as a share of their range.
const NEAR: f64 = 1.0 / 4096.0;

/// How a light is served.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// One map along parallel rays.
    Parallel,
    /// One perspective map.
    Cone,
    /// A map for each face of a cube but the one behind the cone.
    WideCone,
    /// A map for each face of a cube.
    Cube,
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Kind::Parallel => "a directional light",
            Kind::Cone => "a spot light of at most 60 degrees from its axis",
            Kind::WideCone => "a spot light of more than 60 degrees from its axis",
            Kind::Cube => "a point light",
        })
    }
}

pub(super) fn kind(light: &Light) -> Kind {
    match light {
        Light::Directional { .. } | Light::Area { .. } => Kind::Parallel,
        Light::Spot { outer_angle_deg, .. } if *outer_angle_deg <= WIDEST_DEG => Kind::Cone,
        Light::Spot { .. } => Kind::WideCone,
        Light::Point { .. } => Kind::Cube,
    }
}

/// Maps that serve a light.
pub(super) fn layers(light: &Light) -> u32 {
    match kind(light) {
        Kind::Parallel | Kind::Cone => 1,
        Kind::WideCone => 5,
        Kind::Cube => 6,
    }
}

/// Direction in which the light travels along its axis, world space; any for a light that has none.
pub(super) fn direction(light: &Light) -> DVec3 {
    match light {
        Light::Directional { direction, .. } | Light::Spot { direction, .. } => *direction,
        Light::Point { .. } | Light::Area { .. } => DVec3::Y,
    }
}

/// Half the side of a map that leaves nothing out, at unit distance; `None` for parallel light.
pub(super) fn half_side(light: &Light) -> Option<f64> {
    match light {
        Light::Spot { outer_angle_deg, .. } if kind(light) == Kind::Cone => Some(outer_angle_deg.to_radians().tan()),
        Light::Spot { .. } | Light::Point { .. } => Some(1.0),
        Light::Directional { .. } | Light::Area { .. } => None,
    }
}

/// Side of the unfitted map, or of the square of the texels of all unfitted maps of a cube: world units for parallel light,
/// else units at unit distance.
pub(super) fn extent(light: &Light, scene: &SceneBuffers) -> f64 {
    match half_side(light) {
        Some(half) => 2.0 * half * f64::from(layers(light)).sqrt(),
        None => 2.0 * reach(scene).log2().ceil().exp2(),
    }
}

/// Distance of the farthest caster from the scene's origin.
fn reach(scene: &SceneBuffers) -> f64 {
    let farthest = |i: usize| scene.bounds_min[i].abs().max(scene.bounds_max[i].abs());
    DVec3::new(farthest(0), farthest(1), farthest(2)).length().max(1e-30) * (1.0 + 1e-5)
}

/// Axes of each layer; all right-handed, the first that of the light.
fn axes(light: &Light) -> Result<Vec<[DVec3; 3]>, LabError> {
    let [x, y, z] = light_axes(direction(light))?;
    let cube = [[x, y, z], [y, z, x], [z, x, y], [z, y, -x], [x, z, -y], [y, x, -z]];
    Ok(cube[..layers(light) as usize].to_vec())
}

/// The constants of a frame.
pub(super) fn constants(light: &Light, lab: &Lab, bias_texels: f32) -> Result<MapLight, LabError> {
    let origin = lab.scene().origin;
    let eye = lab.view().camera.eye - origin;
    let reach = reach(lab.scene_buffers());
    let mut out = MapLight { eye: word(eye, 0.0), ..MapLight::zeroed() };
    let axes = axes(light)?;
    let placed = match light {
        Light::Spot { position, range, outer_angle_deg, .. } => {
            Some((position, range, outer_angle_deg.to_radians().cos()))
        }
        Light::Point { position, range } => Some((position, range, -2.0)),
        Light::Directional { .. } | Light::Area { .. } => None,
    };
    // a point of zero light-space coordinates, and the largest coordinate of a sample or caster
    let (start, largest) = if let Some((position, range, cosine)) = placed {
        out.depth = [0.0, (NEAR * range) as f32, 0.0, 0.0];
        out.rule = [bias_texels, 0.0, *range as f32, cosine as f32];
        (*position - origin, reach.max((*position - origin).length()))
    } else {
        out.depth = [(-0.5 / reach) as f32, 1.0, 0.0, 0.0];
        out.rule = [bias_texels, 0.0, f32::MAX, -2.0];
        (eye - axes[0][2] * (eye.dot(axes[0][2]) + reach), reach)
    };
    // rounding of a light-space depth: a few units in the last place of the largest coordinate
    out.rule[1] = (16.0 * f64::from(f32::EPSILON) * largest) as f32;
    for (face, [x, y, z]) in out.faces.iter_mut().zip(axes) {
        let axis = |a: DVec3| word(a, a.dot(eye - start));
        *face = Face { x: axis(x), y: axis(y), z: axis(z), origin: [-z.dot(start) as f32, 0.0, 0.0, 0.0] };
    }
    Ok(out)
}

fn word(v: DVec3, w: f64) -> [f32; 4] {
    [v.x as f32, v.y as f32, v.z as f32, w as f32]
}
