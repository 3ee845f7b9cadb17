//! The conventional shadow map (Williams 1978; book, 2.2) with fitting (book, 4.1): one depth image over the scene, over
//! the part of the scene in the view frustum, or over the visible samples. A spot light's map is a perspective one; a point
//! light and a spot light beyond 60 degrees from its axis have one for each face of a cube.

use super::comparison::Comparison;
use super::map::{self, Given, Map, Screen, Shape};
use super::map_cover::Cover;
use super::{DebugPicture, FrameTimes, Method, MethodInfo, MethodSpec, Parameter, Statistics, map_light};
use crate::Light;
use crate::gpu::structs::Slices;
use crate::lab::{Lab, LabError};
use bytemuck::Zeroable;

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
    create: |spec, lab| {
        let settings = settings(spec, SIDE)?;
        let screen = Screen::comparing(lab, &settings.comparison)?;
        Ok(Box::new(Uniform::new(spec, lab, settings, screen)?))
    },
};

pub(super) struct Settings {
    resolution: u32,
    cover: Cover,
    pub(super) comparison: Comparison,
}

/// What the keys of the map say, whatever method they are typed after; `side`: the default.
pub(super) fn settings(spec: &MethodSpec, side: u32) -> Result<Settings, LabError> {
    Ok(Settings {
        resolution: spec.u32_in(RESOLUTION.key, side, 64..=16384)?,
        cover: Cover::of(spec, FIT.default)?,
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
        if settings.cover == Cover::Frustum && lights.iter().any(|l| map_light::half_side(l).is_some()) {
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
}

impl Uniform {
    /// What the CPU gives for a frame of each light.
    pub(super) fn given(&self, lab: &Lab) -> Result<Vec<Given>, LabError> {
        map::check_lights(lab, &self.maps)?;
        let given = |(light, map): (&Light, &Map)| {
            Ok(Given {
                light: map_light::constants(light, lab, self.settings.comparison.bias_texels)?,
                fits: self.settings.cover.fits(lab, light, map)?,
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
        lab.frame(|cmd, timer| {
            map::record((lab, &camera), (cmd, timer), &self.screen, &self.maps, &given, |_, _, _| ())
        })
    }

    of_maps!(self, &self.name, &self.screen, &self.maps);

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
