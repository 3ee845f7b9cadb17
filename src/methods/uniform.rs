//! The conventional shadow map (Williams 1978; book, 2.2) with fitting (book, 4.1): one depth image over the scene, over
//! the part of the scene in the view frustum, or over the visible samples. A spot light's map is a perspective one; a point
//! light and a spot light beyond 60 degrees from its axis have one for each face of a cube.

use super::comparison::Comparison;
use super::map::{self, Given, Map, Screen, Shape};
use super::map_fit::{across, box_corners, frustum_in_box};
use super::{
    DebugPicture, FrameTimes, Masks, Method, MethodInfo, MethodSpec, Parameter, Sampling, Statistics, map_light,
    map_sampling,
};
use crate::Light;
use crate::engine::constants::light_axes;
use crate::gpu::structs::{Fit, Slices};
use crate::lab::{Lab, LabError};
use bytemuck::Zeroable;
use glam::{DVec2, DVec3};

pub(super) const SIDE: u32 = 4096;

/// The keys of the map itself, for methods that start from it.
pub(super) const RESOLUTION: Parameter = Parameter {
    key: "resolution",
    default: "4096",
    allowed: "64 to 16384",
    meaning: "side of the map in texels; a cube's maps share the same number of texels",
};
pub(super) const FIT: Parameter = Parameter {
    key: "fit",
    default: "samples",
    allowed: "scene, frustum or samples",
    meaning: "what the map is fitted to; for spot and point lights scene is the whole cone or cube, and frustum is refused",
};

const PARAMETERS: [Parameter; 7] = Comparison::keys(&[RESOLUTION, FIT]);

pub(super) const INFO: MethodInfo = MethodInfo {
    name: "uniform",
    source: "Williams 1978; Eisemann et al. 2011, 2.2 and 4.1",
    summary: "One conventional map, fitted on the GPU to the visible samples that face the light, turned to least area",
    parameters: &PARAMETERS,
    check: |spec| settings(spec, SIDE).map(|_| ()),
    create: |spec, lab| Ok(Box::new(Uniform::new(spec, lab, settings(spec, SIDE)?, Screen::new(lab)?)?)),
};

#[derive(Clone, Copy, PartialEq, Eq)]
enum FitTo {
    Scene,
    Frustum,
    Samples,
}

pub(super) struct Settings {
    resolution: u32,
    fit: FitTo,
    pub(super) comparison: Comparison,
}

/// What the keys of the map say, whatever method they are typed after; `side`: the default.
pub(super) fn settings(spec: &MethodSpec, side: u32) -> Result<Settings, LabError> {
    Ok(Settings {
        resolution: spec.u32_in(RESOLUTION.key, side, 64..=16384)?,
        fit: match spec.one_of(FIT.key, FIT.default, &["scene", "frustum", "samples"])? {
            "scene" => FitTo::Scene,
            "frustum" => FitTo::Frustum,
            _ => FitTo::Samples,
        },
        comparison: Comparison::of(spec)?,
    })
}

/// The method, and what others start from.
pub(super) struct Uniform {
    name: String,
    settings: Settings,
    pub(super) screen: Screen,
    /// One for each light.
    pub(super) maps: Vec<Map>,
}

impl Uniform {
    /// Maps of silhouettes too where `screen` has edges.
    pub(super) fn new(spec: &MethodSpec, lab: &Lab, settings: Settings, screen: Screen) -> Result<Self, LabError> {
        let lights = &lab.view().lights;
        if settings.fit == FitTo::Frustum && lights.iter().any(|l| map_light::half_side(l).is_some()) {
            return Err(LabError::Refused(format!(
                "'{spec}': fit=frustum serves directional lights; allowed for spot and point lights is fit=scene or samples"
            )));
        }
        let shape = |light| {
            let layers = map_light::layers(light);
            let side = (f64::from(settings.resolution) / f64::from(layers).sqrt()) as u32;
            Shape { side, layers, tiled: false, blend: 0.0, comparison: settings.comparison }
        };
        let maps = lights.iter().map(|l| Map::new(spec, lab, &screen, l, shape(l))).collect::<Result<_, _>>()?;
        Ok(Self { name: spec.name.clone(), settings, screen, maps })
    }

    /// What all lights share, and the map of the first.
    pub(super) fn first(&self) -> (&Screen, &Map) {
        (&self.screen, &self.maps[0])
    }

    /// The fit of each layer that needs no look at the samples.
    fn fixed_fits(&self, lab: &Lab, light: &Light, map: &Map) -> Result<Vec<Fit>, LabError> {
        let points: Vec<_> = match map_light::half_side(light) {
            Some(half) => [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]].map(|c| half * DVec2::from(c)).to_vec(),
            None => {
                let eye = lab.view().camera.eye - lab.scene().origin;
                across(&self.parallel_points(lab), eye, light_axes(map_light::direction(light))?)
            }
        };
        Ok(vec![map.fit(&points); map.shape().layers as usize])
    }

    /// Corners of what a parallel light's map covers, relative to the scene's origin.
    fn parallel_points(&self, lab: &Lab) -> Vec<DVec3> {
        let scene = lab.scene_buffers();
        let bounds = [scene.bounds_min.into(), scene.bounds_max.into()];
        if self.settings.fit == FitTo::Frustum {
            let camera = &lab.view().camera;
            let clipped = frustum_in_box(lab.view(), lab.scene().origin, [camera.near, camera.far], bounds);
            if !clipped.is_empty() {
                return clipped;
            }
        }
        box_corners(bounds).to_vec()
    }
}

impl Uniform {
    /// What the CPU gives for a frame of each light.
    pub(super) fn given(&self, lab: &Lab) -> Result<Vec<Given>, LabError> {
        map::check_lights(lab, &self.maps)?;
        let given = |(light, map): (&Light, &Map)| {
            let fits = match self.settings.fit {
                FitTo::Samples => None,
                _ => Some(self.fixed_fits(lab, light, map)?),
            };
            Ok(Given {
                light: map_light::constants(light, lab, self.settings.comparison.bias_texels)?,
                fits,
                slices: Slices::zeroed(),
            })
        };
        lab.view().lights.iter().zip(&self.maps).map(given).collect()
    }
}

impl Method for Uniform {
    fn frame(&mut self, lab: &Lab) -> Result<FrameTimes, LabError> {
        let given = self.given(lab)?;
        let camera = lab.camera_constants()?;
        lab.frame(|cmd, timer| map::record((lab, &camera), (cmd, timer), &self.screen, &self.maps, &given, |_, _| ()))
    }

    fn visibility(&mut self, lab: &Lab, light: usize) -> Result<Vec<f32>, LabError> {
        super::of_light(&self.maps, &self.name, light)?.visibility(lab)
    }

    fn sampling(&mut self, lab: &Lab, light: usize) -> Result<Option<Sampling>, LabError> {
        super::of_light(&self.maps, &self.name, light)
            .and_then(|map| map_sampling::sampling(lab, &self.screen, map))
            .map(Some)
    }

    fn masks(&self) -> Option<Masks<'_>> {
        Some(map::masks(&self.maps))
    }

    fn memory(&self) -> Vec<(&'static str, u64)> {
        map::memory(&self.screen, &self.maps)
    }

    fn statistics(&mut self, lab: &Lab) -> Result<Statistics, LabError> {
        map::statistics(lab, &self.maps)
    }

    fn debug_pictures(&mut self, lab: &Lab) -> Result<Vec<DebugPicture>, LabError> {
        self.maps.first().map_or(Ok(Vec::new()), |map| map.debug_pictures(lab))
    }
}
