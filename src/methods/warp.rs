//! What the methods with a perspective warp share (book, 4.2): one map of a parallel light, fitted on the GPU to the visible
//! samples, then warped so that texels are smaller where the eye is near. A warp whose texels would look larger in the image
//! than those of the fit without one, on the mean over the samples, does not serve.

use super::comparison::Comparison;
use super::map::{self, Map, Screen, Shape, Step, Warped};
use super::plane::{Plane, Planes};
use super::warp_passes::{self, Axis, Passes, Rule};
use super::{FrameTimes, Method, MethodSpec, Parameter, Statistics, bent};
use crate::gpu::{Timer, spirv};
use crate::lab::{Lab, LabError};

/// Keys that come after those of each.
pub(super) const RESOLUTION: Parameter =
    Parameter { key: "resolution", default: "4096", allowed: "64 to 16384", meaning: "side of the map in texels" };
pub(super) const WARP: Parameter = Parameter {
    key: "warp",
    default: "auto",
    allowed: "auto or always",
    meaning: "whether the warp serves only where its texels look smaller, on the mean over the image, than without",
};

pub(super) struct Settings {
    resolution: u32,
    rule: Rule,
    always: bool,
    logarithm: bool,
    plane: Option<Plane>,
    comparison: Comparison,
}

/// What all of them take, with a rule of their own.
pub(super) fn settings(spec: &MethodSpec, rule: Rule) -> Result<Settings, LabError> {
    Ok(Settings {
        resolution: spec.u32_in(RESOLUTION.key, 4096, 64..=16384)?,
        rule,
        always: spec.one_of(WARP.key, WARP.default, &["auto", "always"])? == "always",
        logarithm: false,
        plane: None,
        comparison: Comparison::of(spec)?,
    })
}

/// The same with a logarithm along the axis.
pub(super) fn logarithmic(spec: &MethodSpec, rule: Rule) -> Result<Settings, LabError> {
    let settings = settings(spec, rule)?;
    bent::check(spec, &settings.comparison)?;
    Ok(Settings { logarithm: true, ..settings })
}

/// The same with the line of a plane.
pub(super) fn of_plane(spec: &MethodSpec, plane: Plane) -> Result<Settings, LabError> {
    Ok(Settings { plane: Some(plane), ..settings(spec, Rule::Plane)? })
}

pub(super) struct Warp {
    name: &'static str,
    settings: Settings,
    screen: Screen,
    map: [Map; 1],
    passes: Passes,
    planes: Option<Planes>,
}

impl Warp {
    pub(super) fn new(name: &'static str, spec: &MethodSpec, lab: &Lab, settings: Settings) -> Result<Self, LabError> {
        super::one_directional(spec, lab)?;
        let screen = Screen::comparing(lab, &settings.comparison)?;
        let Settings { resolution: side, rule, always, logarithm, plane, comparison } = settings;
        let shape = Shape { side, layers: 1, tiled: false, blend: 0.0, comparison };
        let mut map = Map::new(spec, lab, &screen, &lab.view().lights[0], shape)?;
        let passes = Passes::new(lab, &screen, &map, (rule, always, logarithm))?;
        let planes = plane.map(|plane| Planes::new(lab, (&screen, &map), &passes, plane)).transpose()?;
        if logarithm {
            let shaders = [spirv!("methods/logpsm.vert"), spirv!("methods/logpsm.frag")];
            let draws = bent::draws((lab, &map, "logpsm"), shaders, &[], 0)?;
            map.set_warped(Warped { draws, fetches: true, lookup: None });
        }
        Ok(Self { name, settings, screen, map: [map], passes, planes })
    }
}

impl Method for Warp {
    fn frame(&mut self, lab: &Lab) -> Result<FrameTimes, LabError> {
        let given = map::given_samples(lab, &self.map, &self.settings.comparison)?;
        let axis = warp_passes::axis(lab)?;
        let camera = lab.camera_constants()?;
        let [map] = &self.map;
        let steps = |step, cmd, _: &mut Timer| match step {
            Step::Reset => match &self.planes {
                Some(planes) => {
                    planes.reset(lab, cmd);
                    self.passes.reset(cmd, &[Axis::NONE]);
                }
                None => self.passes.reset(cmd, &[axis]),
            },
            Step::Slice | Step::Warp => {}
            Step::Fitted => {
                self.planes.iter().for_each(|planes| planes.record(cmd, &self.screen));
                self.passes.record(cmd, &self.screen, map);
            }
        };
        lab.frame(|cmd, timer| map::record((lab, &camera), (cmd, timer), &self.screen, &self.map, &given, steps))
    }

    of_maps!(self, self.name, &self.screen, &self.map);

    fn memory(&self) -> Vec<(&'static str, u64)> {
        let planes = self.planes.iter().map(|planes| ("planes", planes.bytes()));
        map::memory(&self.screen, &self.map).into_iter().chain(planes).collect()
    }

    fn statistics(&mut self, lab: &Lab) -> Result<Statistics, LabError> {
        let mut statistics = map::statistics(lab, &self.map)?;
        statistics.counters.push(("warped", self.passes.warped(lab)?));
        if let Some(planes) = &self.planes {
            statistics.counters.push(("line_moved", self.passes.moved(lab)?));
            statistics.counters.extend(planes.samples(lab)?.map(|samples| ("plane_samples", samples)));
        }
        Ok(statistics)
    }
}
