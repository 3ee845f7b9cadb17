//! What a map is fitted to: the key `fit` (book, 4.1).

use super::map::Map;
use super::map_fit::{across, box_corners, frustum_in_box};
use super::{MethodSpec, map_light};
use crate::Light;
use crate::engine::constants::light_axes;
use crate::gpu::structs::Fit;
use crate::lab::{Lab, LabError};
use glam::{DVec2, DVec3};

/// What a map covers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Cover {
    /// All casters, or a light's whole cone or cube.
    Scene,
    /// The part of the casters' bounds in the view frustum.
    Frustum,
    /// The visible samples that the light shines on, found on the GPU.
    Samples,
}

impl Cover {
    /// The value of `fit`, or the default.
    pub(super) fn of(spec: &MethodSpec, default: &str) -> Result<Self, LabError> {
        Ok(match spec.one_of("fit", default, &["scene", "frustum", "samples"])? {
            "scene" => Cover::Scene,
            "frustum" => Cover::Frustum,
            _ => Cover::Samples,
        })
    }

    /// The fit of each layer that needs no look at the samples; `None` where it does.
    pub(super) fn fits(self, lab: &Lab, light: &Light, map: &Map) -> Result<Option<Vec<Fit>>, LabError> {
        if self == Cover::Samples {
            return Ok(None);
        }
        let points: Vec<_> = match map_light::half_side(light) {
            Some(half) => [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]].map(|c| half * DVec2::from(c)).to_vec(),
            None => {
                let eye = lab.view().camera.eye - lab.scene().origin;
                across(&self.parallel_points(lab), eye, light_axes(map_light::direction(light))?)
            }
        };
        Ok(Some(vec![map.fit(&points); map.shape().layers as usize]))
    }

    /// Corners of what a parallel light's map covers, relative to the scene's origin.
    fn parallel_points(self, lab: &Lab) -> Vec<DVec3> {
        let scene = lab.scene_buffers();
        let bounds = [scene.bounds_min.into(), scene.bounds_max.into()];
        if self == Cover::Frustum {
            let camera = &lab.view().camera;
            let clipped = frustum_in_box(lab.view(), lab.scene().origin, [camera.near, camera.far], bounds);
            if !clipped.is_empty() {
                return clipped;
            }
        }
        box_corners(bounds).to_vec()
    }
}
