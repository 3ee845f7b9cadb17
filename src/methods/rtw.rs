//! Rectilinear texture warping (Rosen 2012): one map of a parallel light with texels of many sizes, rows and columns being each as
//! wide as what they hold is important. Importance is found on the GPU: from the visible samples (backward analysis), from a
//! coarse depth image of the light (forward), or from both (hybrid).

use super::comparison::Comparison;
use super::map::{self, Given, Map, Screen, Shape, Step, Warped};
use super::map_cover::Cover;
use super::map_sampling::sampling_by;
use super::sampling::Sampling;
use super::{
    DebugPicture, FrameTimes, Masks, Method, MethodInfo, MethodSpec, Parameter, Statistics, bent, map_light,
    rtw_pictures,
};
use crate::gpu::structs::{Fit, RtwPush, Slices};
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Buffer, Compute, Gpu, Graphics, GraphicsState, Image, ImageSpec, Shaders, Timer, spirv};
use crate::lab::{Lab, LabError};
use ash::vk;
use bytemuck::Zeroable;
use std::sync::Arc;

const PARAMETERS: [Parameter; 16] = Comparison::keys(&[
    Parameter { key: "resolution", default: "4096", allowed: "64 to 16384", meaning: "side of the map in texels" },
    Parameter {
        key: "fit",
        default: "samples",
        allowed: "scene, frustum or samples",
        meaning: "what the map covers before it is warped",
    },
    Parameter {
        key: "analysis",
        default: "backward",
        allowed: "forward, backward or hybrid",
        meaning: "where importance is found: in what the light sees, in what the camera sees, or in the latter with shadow edges from the former",
    },
    Parameter {
        key: "view",
        default: "true",
        allowed: "true or false",
        meaning: "whether the map leaves out what the camera does not see; false with analysis=forward only",
    },
    Parameter {
        key: "distance",
        default: "true",
        allowed: "true or false",
        meaning: "whether importance falls with the distance from the eye",
    },
    Parameter {
        key: "normal",
        default: "2",
        allowed: "0 to 16",
        meaning: "importance that a surface gains by facing the eye, as a factor beside 1; 0: none",
    },
    Parameter {
        key: "edge",
        default: "auto",
        allowed: "auto or 0 to 1",
        meaning: "importance left to cells without shadow edges; 1: no difference is made, the only value with analysis=backward; auto: 0.01 with analysis=hybrid, else 1",
    },
    Parameter {
        key: "importance",
        default: "512",
        allowed: "64 to 1024",
        meaning: "side of the importance map in cells, and of the light's depth image in texels",
    },
    Parameter {
        key: "blur",
        default: "3",
        allowed: "0 to 32",
        meaning: "standard deviation of the blur of importance, in cells",
    },
    Parameter {
        key: "stride",
        default: "1",
        allowed: "1 to 8",
        meaning: "every how manieth pixel of every how manieth row backward analysis looks at",
    },
    Parameter {
        key: "subdivide",
        default: "exact",
        allowed: "exact or 0 to 100",
        meaning: "how triangles get the bent edges of a warped map: exact: each texel asks them where it lies; else by splitting edges longer than this percentage of the map's side; 0: not at all",
    },
]);

pub(super) const INFO: MethodInfo = MethodInfo {
    name: "rtw",
    source: "Rosen 2012",
    summary: "One map whose rows and columns are each as wide as what they hold is important, found on the GPU",
    parameters: &PARAMETERS,
    check: |spec| settings(spec).map(|_| ()),
    create: |spec, lab| Ok(Box::new(Rtw::new(spec, lab)?)),
};

#[derive(Clone, Copy, PartialEq, Eq)]
enum Analysis {
    Forward,
    Backward,
    Hybrid,
}

/// How triangles get bent edges.
#[derive(Clone, Copy, PartialEq)]
enum Bent {
    /// Each texel asks where it lies without the warp.
    Exact,
    /// Not at all.
    Straight,
    /// Split where an edge is longer than this share of the map's side.
    Split(f32),
}

struct Settings {
    resolution: u32,
    cover: Cover,
    analysis: Analysis,
    view: bool,
    distance: bool,
    normal: f32,
    edge: f32,
    cells: u32,
    blur: f32,
    stride: u32,
    bent: Bent,
    comparison: Comparison,
}

fn settings(spec: &MethodSpec) -> Result<Settings, LabError> {
    let analysis = match spec.one_of("analysis", "backward", &["forward", "backward", "hybrid"])? {
        "forward" => Analysis::Forward,
        "hybrid" => Analysis::Hybrid,
        _ => Analysis::Backward,
    };
    let flag = |key| Ok::<_, LabError>(spec.one_of(key, "true", &["true", "false"])? == "true");
    let edge = match analysis {
        _ if !spec.is_auto("edge") => spec.f32_in("edge", 1.0, 0.0..=1.0)?,
        Analysis::Hybrid => 0.01,
        _ => 1.0,
    };
    let settings = Settings {
        resolution: spec.u32_in("resolution", 4096, 64..=16384)?,
        cover: Cover::of(spec, "samples")?,
        analysis,
        view: flag("view")?,
        distance: flag("distance")?,
        normal: spec.f32_in("normal", 2.0, 0.0..=16.0)?,
        edge,
        cells: spec.u32_in("importance", 512, 64..=1024)?,
        blur: spec.f32_in("blur", 3.0, 0.0..=32.0)?,
        stride: spec.u32_in("stride", 1, 1..=8)?,
        bent: match spec.value("subdivide") {
            None | Some("exact") => Bent::Exact,
            Some(_) => match spec.f32_in("subdivide", 0.0, 0.0..=100.0)? {
                0.0 => Bent::Straight,
                percent => Bent::Split(0.01 * percent),
            },
        },
        comparison: Comparison::of(spec)?,
    };
    let refused =
        |what: &str, allowed: &str| Err(LabError::Usage(format!("method '{spec}' has {what}, allowed is {allowed}")));
    if analysis == Analysis::Backward && settings.edge < 1.0 {
        return refused("analysis=backward and shadow edges", "edge=1, or analysis=forward or hybrid");
    }
    if analysis != Analysis::Forward && !settings.view {
        return refused("view=false", "analysis=forward with it: only what the camera sees has importance otherwise");
    }
    bent::check(spec, &settings.comparison)?;
    Ok(settings)
}

/// The warp of two axes: what makes it of importance.
pub(crate) struct WarpMaps {
    cells: u32,
    side: u32,
    importance: Buffer,
    collapsed: Buffer,
    warp: Buffer,
    centres: Buffer,
    collapse: Compute,
    build: Compute,
}

impl WarpMaps {
    /// `cells`: along a side of the importance map; `side`: of the map, in texels; `blur`: in cells.
    pub(crate) fn new(gpu: &Arc<Gpu>, cells: u32, side: u32, blur: f32) -> Result<Self, LabError> {
        let storage = |name, bytes: u32| Buffer::storage(gpu, name, u64::from(bytes), vk::BufferUsageFlags::empty());
        let importance = storage("importance", 4 * cells * cells)?;
        let collapsed = storage("importance of rows and columns", 8 * cells)?;
        let warp = storage("warp", 8 * (cells + 1))?;
        let centres = storage("texels of the warp", 16 * side)?;
        let (collapse, build) = (spirv!("methods/rtw_collapse.comp"), spirv!("methods/rtw_warp.comp"));
        let [i, c, w, t] = [&importance, &collapsed, &warp, &centres].map(Binding::Storage);
        Ok(Self {
            collapse: Compute::new(gpu, "rtw_collapse", collapse, &[i, c], &[cells], 0)?,
            build: Compute::new(gpu, "rtw_warp", build, &[c, w, t], &[cells, side, blur.to_bits()], 0)?,
            cells,
            side,
            importance,
            collapsed,
            warp,
            centres,
        })
    }

    pub(crate) fn importance_buffer(&self) -> &Buffer {
        &self.importance
    }

    pub(crate) fn centres(&self) -> &Buffer {
        &self.centres
    }

    fn buffers(&self) -> [&Buffer; 4] {
        [&self.importance, &self.collapsed, &self.warp, &self.centres]
    }

    /// Forgets all importance.
    pub(crate) fn clear(&self, gpu: &Gpu, cmd: vk::CommandBuffer) {
        for buffer in [&self.importance, &self.collapsed] {
            // SAFETY: the command buffer is recording outside of rendering; storage buffers can be filled
            unsafe { gpu.device.cmd_fill_buffer(cmd, buffer.raw, 0, vk::WHOLE_SIZE, 0) };
        }
    }

    /// After importance was written.
    pub(crate) fn record(&self, gpu: &Gpu, cmd: vk::CommandBuffer) {
        let next = || sync::barrier(&gpu.device, cmd, &[(Access::ComputeWrite, Access::ComputeWrite)]);
        next();
        self.collapse.dispatch(cmd, &(), [self.cells.div_ceil(64), self.cells.div_ceil(32), 1]);
        next();
        self.build.dispatch(cmd, &(), [2, 1, 1]);
    }

    /// Importance of the last frame, row by row.
    pub(crate) fn importance(&self, lab: &Lab) -> Result<Vec<f32>, LabError> {
        self.read(lab, &self.importance, self.cells * self.cells)
    }

    /// Where cells begin in the map, and the last ends; along u and along v.
    pub(crate) fn warp(&self, lab: &Lab) -> Result<[Vec<f32>; 2], LabError> {
        let mut u = self.read(lab, &self.warp, 2 * (self.cells + 1))?;
        let v = u.split_off(self.cells as usize + 1);
        Ok([u, v])
    }

    fn read(&self, lab: &Lab, buffer: &Buffer, words: u32) -> Result<Vec<f32>, LabError> {
        Ok(bytemuck::pod_collect_to_vec(&lab.read_buffer(buffer)?[..4 * words as usize]))
    }
}

/// The light's coarse depth image and the pass that finds importance in it.
struct Forward {
    depth: Image,
    analyse: Compute,
}

pub(crate) struct Rtw {
    settings: Settings,
    screen: Screen,
    map: [Map; 1],
    maps: WarpMaps,
    backward: Option<Compute>,
    forward: Option<Forward>,
}

impl Rtw {
    pub(crate) fn new(spec: &MethodSpec, lab: &Lab) -> Result<Self, LabError> {
        super::one_directional(spec, lab)?;
        let settings = settings(spec)?;
        if matches!(settings.bent, Bent::Split(_)) && !lab.has_tessellation() {
            return Err(LabError::Refused(format!(
                "'{spec}' needs tessellation shaders, which device '{}' does not have; allowed is subdivide=exact or 0",
                lab.device_name()
            )));
        }
        let gpu = lab.gpu();
        let screen = Screen::new(lab)?;
        let Settings { resolution: side, comparison, cells, .. } = settings;
        let shape = Shape { side, layers: 1, tiled: false, blend: 0.0, comparison };
        let mut map = Map::new(spec, lab, &screen, &lab.view().lights[0], shape)?;
        let maps = WarpMaps::new(gpu, cells, side, settings.blur)?;
        let own = [Binding::Storage(map.fits()), Binding::Storage(&maps.importance)];
        let samples = [&map.samples(&screen)[..], &own].concat();
        let push = size_of::<RtwPush>();
        let backward = (settings.analysis != Analysis::Forward)
            .then(|| {
                let words = spirv!("methods/rtw_backward.comp");
                Compute::new(gpu, "rtw_backward", words, &samples, &[1, 0, cells], push)
            })
            .transpose()?;
        let forward = (settings.analysis == Analysis::Forward || settings.edge < 1.0)
            .then(|| {
                use vk::ImageUsageFlags as I;
                let spec = ImageSpec {
                    format: vk::Format::D32_SFLOAT,
                    width: cells,
                    height: cells,
                    layers: 1,
                    usage: I::DEPTH_STENCIL_ATTACHMENT | I::SAMPLED,
                };
                let depth = Image::new(gpu, "coarse map", &spec)?;
                let bindings = [&samples[..], &[Binding::Sampled(&depth)]].concat();
                let constants = [1, 0, cells, u32::from(settings.analysis == Analysis::Hybrid)];
                let words = spirv!("methods/rtw_forward.comp");
                let analyse = Compute::new(gpu, "rtw_forward", words, &bindings, &constants, push)?;
                Ok::<_, LabError>(Forward { depth, analyse })
            })
            .transpose()?;
        let warped = warped(lab, &screen, &map, &maps, &settings)?;
        map.set_warped(warped);
        Ok(Self { settings, screen, map: [map], maps, backward, forward })
    }

    /// Importance of the last frame, row by row, and what it covers.
    pub(crate) fn importance(&self, lab: &Lab) -> Result<(Vec<f32>, Fit), LabError> {
        let fit = bytemuck::pod_read_unaligned(&lab.read_buffer(self.map[0].fits())?[..size_of::<Fit>()]);
        Ok((self.maps.importance(lab)?, fit))
    }

    fn push(&self, lab: &Lab) -> RtwPush {
        // 1 - z of normalized device coordinates, which are -1 at the near plane and 1 at the far one (5.2)
        let [near, far] = [lab.view().camera.near, lab.view().camera.far];
        let of_distance = [2.0 * far * near / (far - near), 2.0 * near / (far - near)].map(|v| v as f32);
        RtwPush {
            nearness: if self.settings.distance { of_distance } else { [0.0, -1.0] },
            normal: self.settings.normal,
            edge: self.settings.edge,
            view: u32::from(self.settings.view),
            stride: self.settings.stride,
        }
    }

    /// Finds importance and makes the warp of it.
    fn analyse(&self, lab: &Lab, cmd: vk::CommandBuffer, timer: &mut Timer) {
        use Access::*;
        let device = &lab.gpu().device;
        let push = self.push(lab);
        if let Some(forward) = &self.forward {
            self.map[0].draw_fitted(lab, cmd, &forward.depth);
        }
        if let Some(backward) = &self.backward {
            let groups = lab.view().size.map(|side| side.div_ceil(8 * self.settings.stride));
            backward.dispatch(cmd, &push, [groups[0], groups[1], 1]);
        }
        if let Some(forward) = &self.forward {
            sync::barrier(device, cmd, &[(ComputeWrite, ComputeWrite)]);
            let groups = self.settings.cells.div_ceil(8);
            forward.analyse.dispatch(cmd, &push, [groups, groups, 1]);
        }
        timer.mark(cmd, "importance");
        self.maps.record(lab.gpu(), cmd);
        sync::barrier(device, cmd, &[(ComputeWrite, ComputeRead), (ComputeWrite, GraphicsRead)]);
        timer.mark(cmd, "warp");
    }
}

/// What draws and looks up through the warp.
fn warped(lab: &Lab, screen: &Screen, map: &Map, maps: &WarpMaps, settings: &Settings) -> Result<Warped, LabError> {
    let gpu = lab.gpu();
    let [cells, side, cull] = [settings.cells, settings.resolution, settings.comparison.cull as u32];
    let [warp, centres] = [&maps.warp, &maps.centres].map(Binding::Storage);
    let casters = [&map.casters(lab)[..], &[warp]].concat();
    let pipeline = |masked: bool| {
        let depth_compare = vk::CompareOp::GREATER_OR_EQUAL;
        let layout = lab.scene_buffers().position_layout;
        let state = GraphicsState { depth_compare, ..GraphicsState::casters(layout, true) };
        let split = if let Bent::Split(longest) = settings.bent { Some(longest) } else { None };
        let patch = [spirv!("methods/rtw_patch.tesc"), spirv!("methods/rtw_patch.tese")];
        let shaders = Shaders {
            vertex: if split.is_some() { spirv!("methods/rtw_patch.vert") } else { spirv!("methods/rtw.vert") },
            tessellation: split.map(|_| patch),
            fragment: (masked || cull != 0).then_some(spirv!("methods/map_masked.frag")),
            constants: &[0, 0, cull, cells, split.unwrap_or(1.0).to_bits()],
        };
        Graphics::new(gpu, "rtw", &shaders, &casters, &state)
    };
    let draws = if settings.bent == Bent::Exact {
        let shaders = [spirv!("methods/rtw_exact.vert"), spirv!("methods/rtw_exact.frag")];
        bent::draws((lab, map, "rtw_exact"), shaders, &[warp, centres], cells)?
    } else {
        [pipeline(false)?, pipeline(true)?]
    };
    let (own, constants) = map.lookup(screen);
    let constants = [&constants[..], &[1, 0, cells, side]].concat();
    let bindings = [&map.samples(screen)[..], &own, &[warp, centres]].concat();
    Ok(Warped {
        draws,
        fetches: settings.bent == Bent::Exact,
        lookup: Some(Compute::new(gpu, "rtw_lookup", spirv!("methods/rtw_lookup.comp"), &bindings, &constants, 0)?),
    })
}

impl Method for Rtw {
    fn frame(&mut self, lab: &Lab) -> Result<FrameTimes, LabError> {
        map::check_lights(lab, &self.map)?;
        let light = &lab.view().lights[0];
        let given = Given {
            light: map_light::constants(light, lab, self.settings.comparison.bias_texels)?,
            fits: self.settings.cover.fits(lab, light, &self.map[0])?,
            slices: Slices::zeroed(),
        };
        let camera = lab.camera_constants()?;
        let steps = |step, cmd, timer: &mut Timer| match step {
            Step::Reset => self.maps.clear(lab.gpu(), cmd),
            Step::Slice | Step::Fitted => {}
            Step::Warp => self.analyse(lab, cmd, timer),
        };
        lab.frame(|cmd, timer| map::record((lab, &camera), (cmd, timer), &self.screen, &self.map, &[given], steps))
    }

    fn visibility(&mut self, lab: &Lab, light: usize) -> Result<Vec<f32>, LabError> {
        super::of_light(&self.map, INFO.name, light)?.visibility(lab)
    }

    fn sampling(&mut self, lab: &Lab, light: usize) -> Result<Option<Sampling>, LabError> {
        let map = super::of_light(&self.map, INFO.name, light)?;
        let (words, warp) = (spirv!("methods/rtw_sampling.comp"), [Binding::Storage(&self.maps.warp)]);
        let shader = (words, map.fits(), false);
        let mut sampling = sampling_by(lab, (&self.screen, map), shader, &warp, &[self.settings.cells])?;
        if let Some(inputs) = &mut sampling.inputs {
            inputs.warp = Some(self.maps.warp(lab)?);
        }
        Ok(Some(sampling))
    }

    fn masks(&self) -> Option<Masks<'_>> {
        Some(map::masks(&self.map))
    }

    fn memory(&self) -> Vec<(&'static str, u64)> {
        let mut memory = map::memory(&self.screen, &self.map);
        let depth = self.forward.as_ref().map_or(0, |forward| forward.depth.bytes);
        memory.push(("importance", self.maps.buffers().iter().map(|b| b.size).sum::<u64>() + depth));
        memory
    }

    fn statistics(&mut self, lab: &Lab) -> Result<Statistics, LabError> {
        let mut statistics = map::statistics(lab, &self.map)?;
        let [u, v] = self.maps.warp(lab)?.map(|axis| magnification(&axis));
        // the side of the unwarped map with texels as small as the smallest here (the paper's MER)
        let side = f64::from(self.settings.resolution);
        statistics.counters.extend([("effective_u", (side * u) as u64), ("effective_v", (side * v) as u64)]);
        statistics.effective_resolution *= u.min(v);
        Ok(statistics)
    }

    fn debug_pictures(&mut self, lab: &Lab) -> Result<Vec<DebugPicture>, LabError> {
        let depths = self.map[0].depths(lab)?;
        rtw_pictures::draw(&self.maps.importance(lab)?, &self.maps.warp(lab)?, &depths, self.maps.side)
    }
}

/// How much wider the widest cell is than without a warp.
fn magnification(axis: &[f32]) -> f64 {
    let widest = axis.windows(2).map(|w| f64::from(w[1]) - f64::from(w[0])).fold(0.0, f64::max);
    widest * (axis.len() - 1) as f64
}
