//! The conventional shadow map (Williams 1978; book, 2.2) with fitting (book, 4.1): one depth image over the scene, over
//! the part of the scene in the view frustum, or over the visible samples.

use super::{FrameTimes, Method, MethodInfo, MethodSpec, Parameter, Statistics, hard_directional};
use crate::engine::constants::{Grid, History, constants, light_axes};
use crate::engine::gradient::Gradient;
use crate::gpu::structs::{Fit, Frame};
use crate::gpu::sync::{self, Access};
use crate::gpu::{
    Binding, Buffer, Compute, Gpu, Graphics, GraphicsState, Image, ImageSpec, Memory, Shaders, Timer, set_area, spirv,
};
use crate::host::FrameInput;
use crate::lab::{Lab, LabError};
use crate::{Config, Cull};
use ash::vk;
use bytemuck::Zeroable;
use glam::{DVec2, DVec3};
use std::sync::Arc;

const PARAMETERS: &[Parameter] = &[
    Parameter { key: "resolution", default: "4096", allowed: "64 to 16384", meaning: "side of the map in texels" },
    Parameter {
        key: "fit",
        default: "samples",
        allowed: "scene, frustum or samples",
        meaning: "what the map is fitted to",
    },
    super::DEPTH_BIAS,
    super::CULL,
];

pub(super) const INFO: MethodInfo = MethodInfo {
    name: "uniform",
    source: "Williams 1978; Eisemann et al. 2011, 2.2 and 4.1",
    summary: "One conventional map, fitted on the GPU to the visible samples that face the light, turned to least area",
    parameters: PARAMETERS,
};

/// Rotations of the map that are tried, over a quarter turn.
const ANGLES: u32 = 16;

#[derive(Clone, Copy, PartialEq, Eq)]
enum FitTo {
    Scene,
    Frustum,
    Samples,
}

struct Settings {
    resolution: u32,
    fit: FitTo,
    bias_texels: f32,
    cull: Cull,
}

fn settings(spec: &MethodSpec) -> Result<Settings, LabError> {
    spec.known(PARAMETERS)?;
    Ok(Settings {
        resolution: spec.u32_in("resolution", 4096, 64..=16384)?,
        fit: match spec.one_of("fit", "samples", &["scene", "frustum", "samples"])? {
            "scene" => FitTo::Scene,
            "frustum" => FitTo::Frustum,
            _ => FitTo::Samples,
        },
        bias_texels: spec.f32_in("depth_bias", 1.0, 0.0..=16.0)?,
        cull: super::cull(spec)?,
    })
}

pub(super) fn check(spec: &MethodSpec) -> Result<(), LabError> {
    settings(spec).map(|_| ())
}

pub(super) struct Uniform {
    settings: Settings,
    config: Config,
    frame: Buffer,
    bounds: Buffer,
    fit: Buffer,
    receiver: Image,
    map: Image,
    visibility: Image,
    gradient: Gradient,
    measure: Compute,
    choose: Compute,
    opaque: Graphics,
    masked: Graphics,
    lookup: Compute,
    gpu: Arc<Gpu>,
}

impl Uniform {
    pub(super) fn new(spec: &MethodSpec, lab: &Lab) -> Result<Self, LabError> {
        hard_directional(spec, lab)?;
        let settings = settings(spec)?;
        let gpu = lab.gpu();
        let side = settings.resolution;
        let largest = gpu.limits.max_image_dimension2_d.min(gpu.limits.max_framebuffer_width);
        if side > largest {
            return Err(LabError::Refused(format!("'{spec}': resolution is {side}, this device allows {largest}")));
        }
        let [width, height] = lab.view().size;
        use vk::{BufferUsageFlags as B, Format as F, ImageUsageFlags as I};
        let screen =
            |name, format, usage| Image::new(gpu, name, &ImageSpec { format, width, height, layers: 0, usage });
        let receiver = screen("receiver planes", F::R32G32B32A32_UINT, I::STORAGE | I::SAMPLED)?;
        let visibility = screen("visibility", F::R32_SFLOAT, I::STORAGE | I::TRANSFER_SRC)?;
        let usage = I::DEPTH_STENCIL_ATTACHMENT | I::SAMPLED;
        let map =
            Image::new(gpu, "map", &ImageSpec { format: F::D32_SFLOAT, width: side, height: side, layers: 0, usage })?;
        let frame = Buffer::new(
            gpu,
            "frame constants",
            size_of::<Frame>() as u64,
            B::UNIFORM_BUFFER | B::TRANSFER_DST,
            Memory::Device,
        )?;
        let bounds = Buffer::storage(gpu, "sample bounds", 4 * 4 * u64::from(ANGLES), B::empty())?;
        let fit = Buffer::storage(gpu, "fit", size_of::<Fit>() as u64, B::empty())?;
        let receivers = lab.prepass().receivers();
        let scene = lab.scene_buffers();
        let constants = Binding::Uniform(&frame);
        let samples = [constants, Binding::SampledView(receivers.depth), Binding::Sampled(&receiver)];
        let draw = [
            constants,
            Binding::Storage(&fit),
            Binding::External(scene.instances),
            Binding::External(scene.materials),
            Binding::External(scene.texels),
        ];
        let state = GraphicsState::casters;
        let lookup =
            [samples[0], samples[1], samples[2], draw[1], Binding::Sampled(&map), Binding::StorageImage(&visibility)];
        Ok(Self {
            config: Config { bias_texels: settings.bias_texels, ..Config::new(lab.view().size) },
            gradient: Gradient::new(gpu, constants, &receivers, Binding::StorageImage(&receiver))?,
            measure: Compute::new(
                gpu,
                "uniform_bounds",
                spirv!("methods/uniform_bounds.comp"),
                &[samples[0], samples[1], samples[2], Binding::Storage(&bounds)],
                &[],
                0,
            )?,
            choose: Compute::new(
                gpu,
                "uniform_fit",
                spirv!("methods/uniform_fit.comp"),
                &[Binding::Storage(&bounds), draw[1]],
                &[],
                4,
            )?,
            opaque: Graphics::new(
                gpu,
                "uniform",
                &Shaders { vertex: spirv!("methods/uniform.vert"), fragment: None, constants: &[] },
                &draw[..3],
                &state(false),
            )?,
            masked: Graphics::new(
                gpu,
                "uniform_masked",
                &Shaders {
                    vertex: spirv!("methods/uniform_masked.vert"),
                    fragment: Some(spirv!("methods/uniform_masked.frag")),
                    constants: &[0, 0, settings.cull as u32],
                },
                &draw,
                &state(true),
            )?,
            lookup: Compute::new(gpu, "uniform_lookup", spirv!("methods/uniform_lookup.comp"), &lookup, &[], 0)?,
            settings,
            frame,
            bounds,
            fit,
            receiver,
            map,
            visibility,
            gpu: gpu.clone(),
        })
    }

    /// The fit that needs no look at the samples.
    fn fixed_fit(&self, lab: &Lab) -> Result<Fit, LabError> {
        let input = lab.frame_input();
        let scene = lab.scene_buffers();
        let [x, y, _] = light_axes(input.light_direction)?;
        let eye = input.camera.eye - input.origin;
        let (low, high) = (DVec3::from(scene.bounds_min), DVec3::from(scene.bounds_max));
        let mut points = box_corners(low, high).to_vec();
        if self.settings.fit == FitTo::Frustum {
            let clipped = frustum_in_box(&input, lab.view().size, low, high);
            if !clipped.is_empty() {
                points = clipped;
            }
        }
        let points: Vec<_> = points.iter().map(|p| DVec2::new((*p - eye).dot(x), (*p - eye).dot(y))).collect();
        Ok(least_area(&points, f64::from(self.settings.resolution)))
    }

    fn record(&self, lab: &Lab, cmd: vk::CommandBuffer, timer: &mut Timer, constants: &Frame, fixed: Option<Fit>) {
        use Access::*;
        let device = &self.gpu.device;
        let size = lab.view().size;
        sync::barrier(
            device,
            cmd,
            &[(ComputeRead, TransferWrite), (GraphicsRead, TransferWrite), (ComputeWrite, TransferWrite)],
        );
        // SAFETY: the command buffer is recording; the data is smaller than 64 KiB
        unsafe {
            device.cmd_update_buffer(cmd, self.frame.raw, 0, bytemuck::bytes_of(constants));
            device.cmd_fill_buffer(cmd, self.bounds.raw, 0, vk::WHOLE_SIZE, 0);
            if let Some(fit) = &fixed {
                device.cmd_update_buffer(cmd, self.fit.raw, 0, bytemuck::bytes_of(fit));
            }
        }
        sync::barrier(
            device,
            cmd,
            &[(TransferWrite, ComputeRead), (TransferWrite, ComputeWrite), (TransferWrite, GraphicsRead)],
        );
        sync::discard(device, cmd, &self.receiver, ComputeRead, StorageImage);
        sync::discard(device, cmd, &self.visibility, TransferRead, StorageImage);
        self.gradient.record(cmd, size);
        sync::image(device, cmd, &self.receiver, StorageImage, ComputeRead);
        timer.mark(cmd, "gradient");
        if fixed.is_none() {
            self.measure.dispatch(cmd, &(), [size[0].div_ceil(64), size[1].div_ceil(32), 1]);
            sync::barrier(device, cmd, &[(ComputeWrite, ComputeRead)]);
            self.choose.dispatch(cmd, &(self.settings.resolution as f32), [1, 1, 1]);
            sync::barrier(device, cmd, &[(ComputeWrite, ComputeRead), (ComputeWrite, GraphicsRead)]);
            timer.mark(cmd, "fit");
        }
        sync::discard(device, cmd, &self.map, ComputeRead, DepthAttachment);
        self.draw(lab, cmd);
        sync::image(device, cmd, &self.map, DepthAttachment, ComputeRead);
        timer.mark(cmd, "map");
        self.lookup.dispatch(cmd, &(), [size[0].div_ceil(8), size[1].div_ceil(8), 1]);
        sync::image(device, cmd, &self.visibility, StorageImage, TransferRead);
        timer.mark(cmd, "lookup");
    }

    fn draw(&self, lab: &Lab, cmd: vk::CommandBuffer) {
        let device = &self.gpu.device;
        let scene = lab.scene_buffers();
        let side = self.settings.resolution;
        let attachment = vk::RenderingAttachmentInfo::default()
            .image_view(self.map.view)
            .image_layout(vk::ImageLayout::DEPTH_ATTACHMENT_OPTIMAL)
            .load_op(vk::AttachmentLoadOp::CLEAR)
            .store_op(vk::AttachmentStoreOp::STORE)
            .clear_value(vk::ClearValue { depth_stencil: vk::ClearDepthStencilValue { depth: 1.0, stencil: 0 } });
        let area = vk::Rect2D { offset: vk::Offset2D::default(), extent: vk::Extent2D { width: side, height: side } };
        let info = vk::RenderingInfo::default().render_area(area).layer_count(1).depth_attachment(&attachment);
        // SAFETY: the command buffer is recording; buffers and images outlive the submission
        unsafe {
            device.cmd_begin_rendering(cmd, &info);
            set_area(device, cmd, area);
            device.cmd_bind_index_buffer(cmd, scene.indices, 0, vk::IndexType::UINT32);
            device.cmd_bind_vertex_buffers(cmd, 0, &[scene.positions, scene.attributes], &[0, 0]);
            for (pipeline, alpha_tested) in [(&self.opaque, false), (&self.masked, true)] {
                let pipeline = if self.settings.cull == Cull::None { pipeline } else { &self.masked };
                pipeline.bind(cmd);
                for (d, _) in lab
                    .draws()
                    .iter()
                    .zip(&lab.scene().meshes)
                    .filter(|(d, m)| m.casts && d.alpha_tested == alpha_tested)
                {
                    device.cmd_draw_indexed(cmd, d.index_count, d.instance_count, d.first_index, 0, d.first_instance);
                }
            }
            device.cmd_end_rendering(cmd);
        }
    }
}

impl Method for Uniform {
    fn frame(&mut self, lab: &Lab) -> Result<FrameTimes, LabError> {
        let constants = constants(&self.config, lab.scene_buffers(), &lab.frame_input(), &History::default())?;
        let fixed = if self.settings.fit == FitTo::Samples { None } else { Some(self.fixed_fit(lab)?) };
        lab.frame(|cmd, timer| self.record(lab, cmd, timer, &constants, fixed))
    }

    fn visibility(&mut self, lab: &Lab) -> Result<Vec<f32>, LabError> {
        Ok(bytemuck::pod_collect_to_vec(&lab.read_image(&self.visibility, Access::TransferRead, 4)?))
    }

    fn memory(&self) -> Vec<(&'static str, u64)> {
        vec![
            ("map", self.map.bytes),
            ("screen", self.receiver.bytes + self.visibility.bytes),
            ("other", self.frame.size + self.bounds.size + self.fit.size),
        ]
    }

    fn statistics(&mut self, lab: &Lab) -> Result<Statistics, LabError> {
        let fit: Fit = bytemuck::pod_read_unaligned(&lab.read_buffer(&self.fit)?[..size_of::<Fit>()]);
        let texel = f64::from(fit.texel[0].min(fit.texel[1]));
        let grid = Grid::new(lab.frame_input().light_direction, lab.scene_buffers())?;
        Ok(Statistics { effective_resolution: grid.extent() / texel, ..Statistics::default() })
    }
}

fn box_corners(low: DVec3, high: DVec3) -> [DVec3; 8] {
    std::array::from_fn(|i| {
        let pick = |axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
        DVec3::new(pick(0), pick(1), pick(2))
    })
}

/// Vertices of the intersection of the view frustum and a box, both relative to the scene's origin (book, 4.1):
/// the faces of each body clipped by the planes of the other.
fn frustum_in_box(input: &FrameInput, size: [u32; 2], low: DVec3, high: DVec3) -> Vec<DVec3> {
    let camera = &input.camera;
    let eye = camera.eye - input.origin;
    let view = camera.view_from_world();
    let (right, up, back) = (view.row(0), view.row(1), view.row(2));
    let tan_y = (0.5 * camera.fov_y_deg.to_radians()).tan();
    let tan_x = tan_y * f64::from(size[0]) / f64::from(size[1]);
    let corner = |i: usize| {
        let sign = |bit: usize| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
        let z = if i >> 2 & 1 == 0 { camera.near } else { camera.far };
        eye + (right * (sign(0) * tan_x) + up * (sign(1) * tan_y) - back) * z
    };
    let frustum: [DVec3; 8] = std::array::from_fn(corner);
    let bodies = [frustum, box_corners(low, high)];
    // corner i has bit 0 for the first axis, bit 1 for the second, bit 2 for the third: these are the faces
    const FACES: [[usize; 4]; 6] = [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]];
    let mut points = Vec::new();
    for (body, other) in [(0, 1), (1, 0)] {
        let middle = bodies[other].iter().sum::<DVec3>() / 8.0;
        for face in FACES {
            let mut polygon: Vec<_> = face.iter().map(|&i| bodies[body][i]).collect();
            for plane in FACES {
                let [a, b, c] = [plane[0], plane[1], plane[2]].map(|i| bodies[other][i]);
                let normal = (b - a).cross(c - a);
                let normal = if normal.dot(middle - a) < 0.0 { -normal } else { normal };
                polygon = clip(&polygon, |p| normal.dot(p - a));
            }
            points.extend(polygon);
        }
    }
    points
}

/// The part of a convex polygon where `distance` is not negative (Sutherland, Hodgman).
fn clip(polygon: &[DVec3], distance: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let mut out = Vec::with_capacity(polygon.len() + 1);
    for (i, &p) in polygon.iter().enumerate() {
        let q = polygon[(i + 1) % polygon.len()];
        let (dp, dq) = (distance(p), distance(q));
        if dp >= 0.0 {
            out.push(p);
        }
        if (dp >= 0.0) != (dq >= 0.0) {
            out.push(p + (q - p) * (dp / (dp - dq)));
        }
    }
    out
}

/// The rectangle of least area among [`ANGLES`] rotations that holds all points, with a texel of border.
fn least_area(points: &[DVec2], resolution: f64) -> Fit {
    let mut best = (f64::INFINITY, Fit::zeroed());
    for a in 0..ANGLES {
        let (sin, cos) = (f64::from(a) * std::f64::consts::FRAC_PI_2 / f64::from(ANGLES)).sin_cos();
        let turned = points.iter().map(|p| DVec2::new(cos * p.x + sin * p.y, cos * p.y - sin * p.x));
        let (low, high) = turned.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        let size = ((high - low) * (resolution / (resolution - 2.0))).max(DVec2::splat(1e-9));
        let low = 0.5 * (low + high) - 0.5 * size;
        if size.x * size.y < best.0 {
            let row =
                |x: f64, y: f64, low: f64, size: f64| [(x / size) as f32, (y / size) as f32, (-low / size) as f32, 0.0];
            let fit = Fit {
                row_u: row(cos, sin, low.x, size.x),
                row_v: row(-sin, cos, low.y, size.y),
                texel: [(size.x / resolution) as f32, (size.y / resolution) as f32, 0.0, 0.0],
            };
            best = (size.x * size.y, fit);
        }
    }
    best.1
}
