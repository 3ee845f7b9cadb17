//! Cascaded shadow maps (Engel 2006; Zhang et al. 2006; book, 4.3.1): the visible depths are divided into slices, and each
//! slice has a map of its own. Slices and maps are fitted to the visible samples (Lauritzen et al. 2011) or to the frustum.
//! Or a map for each face of the view frustum (Kozlov 2004; book, 4.3.2), see `frustum_faces.rs`.

use super::comparison::Comparison;
use super::frustum_faces::{self, FACES};
use super::map::{self, Given, Map, Screen, Shape, Step};
use super::map_fit::{across, frustum_in_box, slice_sphere, snapped};
use super::warp_passes::{self, Passes, Rule};
use super::{FrameTimes, Method, MethodInfo, MethodSpec, Parameter, Statistics, map_light};
use crate::engine::constants::light_axes;
use crate::gpu::structs::{Fit, Slices};
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Compute, Timer, spirv};
use crate::lab::{Lab, LabError};
use ash::vk;
use bytemuck::Zeroable;
use glam::{DVec2, DVec3};

const PARAMETERS: [Parameter; 13] = Comparison::keys(&[
    Parameter {
        key: "partition",
        default: "depth",
        allowed: "depth or faces",
        meaning: "what has a map of its own: slices of depth, or, fitted to samples, the near face and the sides of the view frustum, by which the light's lines leave it; then without cascades, lambda, fit, blend and snap",
    },
    Parameter { key: "cascades", default: "4", allowed: "1 to 8", meaning: "number of maps" },
    Parameter { key: "resolution", default: "2048", allowed: "64 to 8192", meaning: "side of each map in texels" },
    Parameter {
        key: "lambda",
        default: "1",
        allowed: "0 to 1",
        meaning: "share of logarithmic splits, the rest is equidistant; 0.75 where fit is frustum",
    },
    Parameter {
        key: "fit",
        default: "samples",
        allowed: "frustum or samples",
        meaning: "what slices and maps are fitted to",
    },
    Parameter {
        key: "blend",
        default: "0",
        allowed: "0 to 0.5",
        meaning: "share of a slice at whose end its map gives way to the next one's, so that no seam is seen",
    },
    Parameter {
        key: "snap",
        default: "false",
        allowed: "false or true",
        meaning: "with fit=frustum: squares of one size whose texels stay in the world while the eye moves",
    },
    Parameter {
        key: "warp",
        default: "none",
        allowed: "none, auto or always",
        meaning: "whether each map is warped as by lispsm (book, 4.3.3): not, where its texels then look smaller, or always; auto where partition is faces",
    },
]);

pub(super) const INFO: MethodInfo = MethodInfo {
    name: "csm",
    source: "Engel 2006; Zhang et al. 2006; Lauritzen et al. 2011; Eisemann et al. 2011, 4.3.1",
    summary: "A map for each slice of depth, slices and maps fitted on the GPU to the visible samples",
    parameters: &PARAMETERS,
    check: |spec| settings(spec).map(|_| ()),
    create: |spec, lab| Ok(Box::new(Csm::new(spec, lab)?)),
};

struct Settings {
    /// Layers are faces of the view frustum, not slices.
    faces: bool,
    cascades: u32,
    resolution: u32,
    lambda: f32,
    to_samples: bool,
    blend: f32,
    snap: bool,
    /// With whether it serves even where it gains nothing.
    warp: Option<bool>,
    comparison: Comparison,
}

fn settings(spec: &MethodSpec) -> Result<Settings, LabError> {
    let faces = spec.one_of("partition", "depth", &["depth", "faces"])? == "faces";
    let of_depth = ["cascades", "lambda", "fit", "blend", "snap"].into_iter().find(|key| spec.value(key).is_some());
    if let (true, Some(key)) = (faces, of_depth) {
        return Err(LabError::Usage(format!(
            "method '{spec}' has partition=faces and a {key}, allowed is {key} with partition=depth"
        )));
    }
    let to_samples = spec.one_of("fit", "samples", &["frustum", "samples"])? == "samples";
    // logarithmic splits waste maps on an empty range behind the near plane (book, 4.3.1); samples leave no such range
    let lambda = if to_samples { 1.0 } else { 0.75 };
    let snap = spec.one_of("snap", "false", &["false", "true"])? == "true";
    if snap && to_samples {
        return Err(LabError::Usage(format!(
            "method '{spec}' has snap=true, allowed is snap=false without fit=frustum"
        )));
    }
    let warp = match spec.one_of("warp", if faces { "auto" } else { "none" }, &["none", "auto", "always"])? {
        "none" => None,
        _ if !to_samples => {
            return Err(LabError::Usage(format!("method '{spec}' has a warp, allowed is warp=none with fit=frustum")));
        }
        which => Some(which == "always"),
    };
    Ok(Settings {
        faces,
        cascades: if faces { FACES as u32 } else { spec.u32_in("cascades", 4, 1..=8)? },
        resolution: spec.u32_in("resolution", 2048, 64..=8192)?,
        lambda: spec.f32_in("lambda", lambda, 0.0..=1.0)?,
        to_samples,
        blend: spec.f32_in("blend", 0.0, 0.0..=0.5)?,
        snap,
        warp,
        comparison: Comparison::of(spec)?,
    })
}

pub(super) struct Csm {
    settings: Settings,
    screen: Screen,
    map: [Map; 1],
    extremes: Compute,
    splits: Compute,
    warps: Option<Passes>,
}

impl Csm {
    pub(super) fn new(spec: &MethodSpec, lab: &Lab) -> Result<Self, LabError> {
        super::one_directional(spec, lab)?;
        let settings = settings(spec)?;
        let gpu = lab.gpu();
        let screen = Screen::comparing(lab, &settings.comparison)?;
        let shape = Shape {
            side: settings.resolution,
            layers: settings.cascades,
            tiled: false,
            blend: settings.blend,
            comparison: settings.comparison,
        };
        let map = Map::new(spec, lab, &screen, &lab.view().lights[0], shape)?;
        let warps =
            settings.warp.map(|always| Passes::new(lab, &screen, &map, (Rule::Even, always, false))).transpose()?;
        let (frame, slices) = (Binding::Uniform(&screen.frame), Binding::Storage(map.slices()));
        let depth = Binding::Sampled(&screen.receivers.depth);
        let (extremes, splits) = (spirv!("methods/csm_extremes.comp"), spirv!("methods/csm_splits.comp"));
        Ok(Self {
            extremes: Compute::new(gpu, "csm_extremes", extremes, &[frame, depth, slices], &[], 0)?,
            splits: Compute::new(gpu, "csm_splits", splits, &[slices], &[settings.cascades], 4)?,
            settings,
            screen,
            map: [map],
            warps,
        })
    }

    /// Divides the depths between the nearest and the farthest visible sample; the near face lies at the nearest.
    fn slice(&self, lab: &Lab, cmd: vk::CommandBuffer) {
        use Access::*;
        let between = || sync::barrier(&lab.gpu().device, cmd, &[(ComputeWrite, ComputeWrite)]);
        self.extremes.dispatch(cmd, &(), self.screen.columns());
        between();
        if !self.settings.faces {
            self.splits.dispatch(cmd, &self.settings.lambda, [1, 1, 1]);
            between();
        }
    }

    /// Slices that depend on the camera's angles and the scene alone, in squares whose texels stay in the world.
    fn snapped_fits(&self, lab: &Lab) -> Result<(Vec<Fit>, Slices), LabError> {
        let (view, scene) = (lab.view(), lab.scene_buffers());
        let camera = &view.camera;
        let [x, y, _] = light_axes(map_light::direction(&view.lights[0]))?;
        let across = |v: DVec3| DVec2::new(v.dot(x), v.dot(y));
        let eye = across(camera.eye - lab.scene().origin);
        let forward = across(-camera.view_from_world().row(2));
        let tan = (0.5 * camera.fov_y_deg.to_radians()).tan();
        let tan = DVec2::new(tan * f64::from(view.size[0]) / f64::from(view.size[1]), tan);
        // what is seen of the scene ends at most this far away; wherever the eye is in it
        let diagonal = DVec3::from(scene.bounds_max).distance(scene.bounds_min.into());
        let far = camera.far.min(diagonal).max(2.0 * camera.near);
        let slices = self.split(camera.near, far);
        let shape = self.map[0].shape();
        let fits = self.ranges(&slices).map(|range| {
            let [middle, radius] = slice_sphere(range, tan);
            snapped(eye + forward * middle, radius, eye, shape.side.into(), shape.border().into())
        });
        Ok((fits.collect(), slices))
    }

    /// The depths that each map holds: its slice, and the end of the one before, which gives way to it.
    fn ranges<'a>(&self, slices: &'a Slices) -> impl Iterator<Item = [f64; 2]> + use<'a> {
        let (cascades, blend) = (self.settings.cascades as usize, f64::from(self.settings.blend));
        (0..cascades).map(move |i| {
            let [before, begin, end] = [i.saturating_sub(1), i, i + 1].map(|i| f64::from(slices.splits[i]));
            [begin - blend * (begin - before), end]
        })
    }

    /// Practical splits.
    fn split(&self, near: f64, far: f64) -> Slices {
        let mut slices = Slices::zeroed();
        let cascades = self.settings.cascades as usize;
        for (i, split) in slices.splits[..=cascades].iter_mut().enumerate() {
            *split = practical_split(near, far, i as f64 / cascades as f64, self.settings.lambda.into()) as f32;
        }
        slices
    }

    /// Slices of the part of the scene in the frustum, and the fit of each.
    fn frustum_fits(&self, lab: &Lab) -> Result<(Vec<Fit>, Slices), LabError> {
        let (view, origin, scene) = (lab.view(), lab.scene().origin, lab.scene_buffers());
        let bounds = [scene.bounds_min.into(), scene.bounds_max.into()];
        let clipped = |depths| frustum_in_box(view, origin, depths, bounds);
        let camera = &view.camera;
        let eye = camera.eye - origin;
        let forward = -camera.view_from_world().row(2);
        let depths = clipped([camera.near, camera.far]).into_iter().map(|p| forward.dot(p - eye));
        let (near, far) = depths.fold((camera.far, camera.near), |(n, f), d| (d.min(n), d.max(f)));
        let near = near.clamp(camera.near, camera.far);
        let far = far.clamp(near, camera.far);
        let slices = self.split(near, far);
        let axes = light_axes(map_light::direction(&view.lights[0]))?;
        let fits = self.ranges(&slices).map(|range| {
            let points = clipped(range);
            self.map[0].shape().fit(&across(&points, eye, axes))
        });
        Ok((fits.collect(), slices))
    }
}

/// Where a slice begins: a mean of logarithmic and equidistant splits (Zhang et al. 2006). `share`: of the slices before it.
fn practical_split(near: f64, far: f64, share: f64, lambda: f64) -> f64 {
    lambda * near * (far / near).powf(share) + (1.0 - lambda) * (near + share * (far - near))
}

impl Method for Csm {
    fn frame(&mut self, lab: &Lab) -> Result<FrameTimes, LabError> {
        map::check_lights(lab, &self.map)?;
        let light = map_light::constants(&lab.view().lights[0], lab, self.settings.comparison.bias_texels)?;
        let (slices, axes) = if self.settings.faces {
            let (slices, axes) = frustum_faces::faces(lab)?;
            (slices, axes.to_vec())
        } else {
            (Slices::zeroed(), vec![warp_passes::axis(lab)?; self.settings.cascades as usize])
        };
        let given = if self.settings.to_samples {
            Given { light, fits: None, slices }
        } else {
            let (fits, slices) = if self.settings.snap { self.snapped_fits(lab)? } else { self.frustum_fits(lab)? };
            Given { light, fits: Some(fits), slices }
        };
        let [map] = &self.map;
        let steps = |step, cmd, _: &mut Timer| match (step, &self.warps) {
            (Step::Reset, Some(warps)) => warps.reset(cmd, &axes),
            (Step::Slice, _) => self.slice(lab, cmd),
            (Step::Fitted, Some(warps)) => warps.record(cmd, &self.screen, map),
            _ => {}
        };
        let camera = lab.camera_constants()?;
        lab.frame(|cmd, timer| map::record((lab, &camera), (cmd, timer), &self.screen, &self.map, &[given], steps))
    }

    of_maps!(self, INFO.name, &self.screen, &self.map);

    fn memory(&self) -> Vec<(&'static str, u64)> {
        map::memory(&self.screen, &self.map)
    }

    fn statistics(&mut self, lab: &Lab) -> Result<Statistics, LabError> {
        let mut statistics = map::statistics(lab, &self.map)?;
        if let Some(warps) = &self.warps {
            statistics.counters.push(("warped", warps.warped(lab)?));
        }
        Ok(statistics)
    }
}

#[cfg(test)]
mod tests {
    use super::practical_split;

    #[test]
    fn splits_are_those_of_the_source() {
        let splits = |lambda| [0.0, 0.5, 1.0].map(|share| practical_split(1.0, 100.0, share, lambda));
        for (lambda, middle) in [(0.0, 50.5), (1.0, 10.0), (0.5, 30.25)] {
            let got = splits(lambda);
            for (got, want) in got.iter().zip([1.0, middle, 100.0]) {
                assert!((got - want).abs() < 1e-9, "lambda {lambda}: {got}, not {want}");
            }
        }
    }
}
