//! Confidence-weighted temporal reprojection (Scherzer et al. 2007; book, 4.7): the texel grid of one conventional map lies
//! elsewhere in each frame, and each pixel keeps a mean of its lookups, weighted by how near they were to the middle of their texel.
//! The history of a surface is found where the camera of the frame before saw it.

use super::changes::{Changes, merged};
use super::comparison::Comparison;
use super::map::{self, Given, Screen, Step, screen_image};
use super::uniform::{self, FIT, RESOLUTION, SIDE, Uniform};
use super::{FrameTimes, Masks, Method, MethodInfo, MethodSpec, Parameter, Sampling, Statistics};
use crate::Light;
use crate::gpu::structs::{Fit, Frame, TemporalJitter, TemporalPush};
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Buffer, Compute, Image, Timer, spirv};
use crate::lab::{Lab, LabError};
use ash::vk;
use glam::{DVec3, Vec3};

const PARAMETERS: [Parameter; 12] = Comparison::keys(&[
    RESOLUTION,
    FIT,
    Parameter {
        key: "exponent",
        default: "4",
        allowed: "0.25 to 64",
        meaning: "a lookup's weight is its confidence to this power",
    },
    Parameter {
        key: "memory",
        default: "64",
        allowed: "0 to 4096",
        meaning: "most weight that the history has, in lookups of full confidence; 0: exponential smoothing, the rest of the new lookup's weight",
    },
    Parameter {
        key: "rotation",
        default: "0",
        allowed: "0 to 45",
        meaning: "most degrees by which the texel grid turns, either way",
    },
    Parameter {
        key: "rejection",
        default: "0.01",
        allowed: "0.0001 to 1",
        meaning: "share of its depth by which a surface may lie elsewhere than in the frame before and still be the same",
    },
    Parameter {
        key: "frames",
        default: "0",
        allowed: "0 to 256",
        meaning: "frames drawn from an empty history in each call; 0: one, and the history goes on",
    },
]);

pub(super) const INFO: MethodInfo = MethodInfo {
    name: "temporal",
    source: "Scherzer, Jeschke, Wimmer 2007; Eisemann et al. 2011, 4.7",
    summary: "One map whose texels lie elsewhere in each frame; pixels keep a mean of their lookups from frame to frame",
    parameters: &PARAMETERS,
    check: |spec| settings(spec).map(|_| ()),
    create: |spec, lab| Ok(Box::new(Temporal::new(spec, lab)?)),
};

/// Boxes around what moved that the GPU is given at most; more are merged.
const MOST_BOXES: usize = 64;
/// How the history is found; as in `glsl/methods/temporal_blend.comp`.
const HISTORY_NONE: u32 = 0;
const HISTORY_STILL: u32 = 1;
const HISTORY_MOVED: u32 = 2;

struct Settings {
    exponent: f32,
    memory: f32,
    rotation: f64,
    rejection: f32,
    frames: u32,
}

fn settings(spec: &MethodSpec) -> Result<Settings, LabError> {
    uniform::settings(spec, SIDE)?;
    Ok(Settings {
        exponent: spec.f32_in("exponent", 4.0, 0.25..=64.0)?,
        memory: spec.f32_in("memory", 64.0, 0.0..=4096.0)?,
        rotation: f64::from(spec.f32_in("rotation", 0.0, 0.0..=45.0)?).to_radians(),
        rejection: spec.f32_in("rejection", 0.01, 1e-4..=1.0)?,
        frames: spec.u32_in("frames", 0, 0..=256)?,
    })
}

/// The digits of a number behind the point in reverse order (van der Corput).
fn radical_inverse(mut number: u32, base: u32) -> f64 {
    let (mut inverse, mut share) = (0.0, 1.0 / f64::from(base));
    while number > 0 {
        inverse += f64::from(number % base) * share;
        number /= base;
        share /= f64::from(base);
    }
    inverse
}

/// Where a frame's texel grid lies: moved by up to half a texel either way and turned by up to `rotation` either way (Halton
/// points), and as much smaller as its corners then need.
fn jitter(frame: u32, rotation: f64, side: u32) -> TemporalJitter {
    let [x, y, turn] = [2, 3, 5].map(|base| radical_inverse(frame + 1, base) - 0.5);
    let (sin, cos) = (2.0 * turn * rotation).sin_cos();
    let room = cos + sin.abs();
    TemporalJitter {
        turn: [(cos / room) as f32, (sin / room) as f32],
        shift: [(x / f64::from(side)) as f32, (y / f64::from(side)) as f32],
    }
}

/// As `glsl/methods/temporal_jitter.comp`.
fn jittered(fit: &Fit, TemporalJitter { turn: [cos, sin], shift }: TemporalJitter) -> Fit {
    let around = |row: [f32; 4]| [0, 1, 2].map(|i| row[i] - 0.5 * fit.row_w[i]);
    let (u, v) = (around(fit.row_u), around(fit.row_v));
    let row = |a: f32, b: f32, shift: f32| {
        let [x, y, z] = [0, 1, 2].map(|i| a * u[i] + b * v[i] + (0.5 + shift) * fit.row_w[i]);
        [x, y, z, 0.0]
    };
    let [width, height] = [0, 1].map(|i| fit.texel[i] / (cos * cos + sin * sin));
    Fit {
        row_u: row(cos, -sin, shift[0]),
        row_v: row(sin, cos, shift[1]),
        texel: [(cos * width).hypot(sin * height), (sin * width).hypot(cos * height), 0.0, 0.0],
        ..*fit
    }
}

/// What the frame before was.
struct Before {
    camera: Frame,
    eye: DVec3,
    light: Light,
}

pub(super) struct Temporal {
    settings: Settings,
    base: Uniform,
    /// Read and written by turns.
    history: [Image; 2],
    boxes: Buffer,
    jitter: Compute,
    /// From the first history to the second, and back.
    blend: [Compute; 2],
    /// Frames so far.
    frame: u32,
    changes: Changes,
    before: Option<Before>,
}

impl Temporal {
    pub(super) fn new(spec: &MethodSpec, lab: &Lab) -> Result<Self, LabError> {
        super::one_directional(spec, lab)?;
        let gpu = lab.gpu();
        let mut map = uniform::settings(spec, SIDE)?;
        map.comparison.centred = true;
        let screen = Screen::comparing(lab, &map.comparison)?;
        let base = Uniform::new(spec, lab, map, screen)?;
        let map = &base.maps[0];
        let image = || screen_image(lab, "history", vk::Format::R32G32B32A32_UINT, vk::ImageUsageFlags::STORAGE);
        let history = [image()?, image()?];
        let boxes = Buffer::storage(gpu, "moved", 32 * MOST_BOXES as u64, vk::BufferUsageFlags::empty())?;
        let blend = |from: &Image, to: &Image| {
            let own = [
                Binding::Storage(map.fits()),
                Binding::StorageImage(map.visibility_image()),
                Binding::StorageImage(from),
                Binding::StorageImage(to),
                Binding::Storage(&boxes),
            ];
            let bindings = [&map.samples(&base.screen)[..], &own].concat();
            let words = spirv!("methods/temporal_blend.comp");
            Compute::new(gpu, "temporal_blend", words, &bindings, &[1, 0], size_of::<TemporalPush>())
        };
        let jitter = spirv!("methods/temporal_jitter.comp");
        let fits = [Binding::Storage(map.fits())];
        Ok(Self {
            settings: settings(spec)?,
            jitter: Compute::new(gpu, "temporal_jitter", jitter, &fits, &[], size_of::<TemporalJitter>())?,
            blend: [blend(&history[0], &history[1])?, blend(&history[1], &history[0])?],
            history,
            boxes,
            base,
            frame: 0,
            changes: Changes::default(),
            before: None,
        })
    }

    /// One frame; `first`: nothing of the history is used.
    fn one(&mut self, lab: &Lab, first: bool) -> Result<FrameTimes, LabError> {
        let Settings { exponent, memory, rotation, rejection, .. } = self.settings;
        let mut given = self.base.given(lab)?;
        let (camera, eye) = (lab.camera_constants()?, lab.view().camera.eye);
        let light = lab.view().lights[0].clone();
        let moved = self.changes.since(lab);
        let before = self.before.take().filter(|before| !first && before.light == light);
        let boxes: Vec<[[f32; 4]; 2]> = merged(moved.as_deref().unwrap_or_default(), MOST_BOXES)
            .iter()
            .map(|corners| corners.map(|c: Vec3| c.extend(0.0).to_array()))
            .collect();
        let history = match (&before, &moved) {
            (None, _) | (_, None) => HISTORY_NONE,
            (Some(before), _) if before.camera == camera && before.eye == eye => HISTORY_STILL,
            _ => HISTORY_MOVED,
        };
        self.frame = if history == HISTORY_NONE { 0 } else { self.frame + 1 };
        let map = &self.base.maps[0];
        let side = map.shape().side;
        let push = TemporalPush {
            clip_before: before.as_ref().map_or(camera, |b| b.camera).clip_from_eye,
            eye_moved: before.as_ref().map_or(DVec3::ZERO, |b| eye - b.eye).as_vec3().extend(0.0).to_array(),
            exponent,
            memory,
            rejection,
            moved: boxes.len() as u32,
            side,
            history,
        };
        let jitter = jitter(self.frame, rotation, side);
        for Given { fits, .. } in &mut given {
            fits.iter_mut().flatten().for_each(|fit| *fit = jittered(fit, jitter));
        }
        let device = &lab.gpu().device;
        let steps = |step, cmd, _: &mut Timer| match step {
            Step::Reset if !boxes.is_empty() => {
                let bytes = bytemuck::cast_slice(&boxes);
                // SAFETY: the command buffer is recording; the boxes fit the buffer; earlier reads of it are waited for
                unsafe { device.cmd_update_buffer(cmd, self.boxes.raw, 0, bytes) };
            }
            Step::Reset | Step::Slice | Step::Warp => {}
            Step::Fitted => self.jitter.dispatch(cmd, &jitter, [1, 1, 1]),
        };
        let times = lab.frame(|cmd, timer| {
            use Access::*;
            if history == HISTORY_NONE {
                self.history.iter().for_each(|image| sync::discard(device, cmd, image, StorageImage, StorageImage));
            }
            map::record((lab, &camera), (cmd, timer), &self.base.screen, &self.base.maps, &given, steps);
            sync::image(device, cmd, map.visibility_image(), TransferRead, StorageImage);
            sync::barrier(device, cmd, &[(ComputeWrite, ComputeWrite)]);
            let [width, height] = lab.view().size;
            self.blend[self.frame as usize % 2].dispatch(cmd, &push, [width.div_ceil(8), height.div_ceil(8), 1]);
            sync::image(device, cmd, map.visibility_image(), StorageImage, TransferRead);
            timer.mark(cmd, "blend");
        })?;
        self.before = Some(Before { camera, eye, light });
        Ok(times)
    }
}

impl Method for Temporal {
    fn frame(&mut self, lab: &Lab) -> Result<FrameTimes, LabError> {
        if self.settings.frames == 0 {
            return self.one(lab, false);
        }
        let mut sum = self.one(lab, true)?;
        for _ in 1..self.settings.frames {
            let times = self.one(lab, false)?;
            sum.ms += times.ms;
            sum.wall_ms += times.wall_ms;
            sum.prepass_ms += times.prepass_ms;
            sum.stages.iter_mut().zip(&times.stages).for_each(|(sum, stage)| sum.1 += stage.1);
        }
        Ok(sum)
    }

    fn visibility(&mut self, lab: &Lab, light: usize) -> Result<Vec<f32>, LabError> {
        self.base.visibility(lab, light)
    }

    fn masks(&self) -> Option<Masks<'_>> {
        self.base.masks()
    }

    fn memory(&self) -> Vec<(&'static str, u64)> {
        let mut memory = self.base.memory();
        memory.push(("history", self.history.iter().map(|image| image.bytes).sum()));
        memory
    }

    fn sampling(&mut self, lab: &Lab, light: usize) -> Result<Option<Sampling>, LabError> {
        self.base.sampling(lab, light)
    }

    fn statistics(&mut self, lab: &Lab) -> Result<Statistics, LabError> {
        self.base.statistics(lab)
    }
}
