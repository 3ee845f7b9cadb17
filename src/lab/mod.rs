//! The bench on which methods are compared: one device, one scene, one view, one depth prepass for all of them.

pub(crate) mod device;
#[doc(hidden)]
pub mod foreign;
mod motion;
mod shapes;
#[doc(hidden)]
pub mod stages;
#[doc(hidden)]
pub mod stages_asm;
#[doc(hidden)]
pub mod stages_exact;
#[doc(hidden)]
pub mod stages_rtw;
#[doc(hidden)]
pub mod stages_tree;
mod upload;

pub use device::{DeviceReport, devices};

use crate::engine::constants::camera_constants;
use crate::engine::depth_prepass::{DepthPrepass, MeshDraw};
use crate::engine::{Engine, FrameId};
use crate::gpu::sync::{self, Access};
use crate::gpu::{Buffer, Gpu, Image, Memory, Timer, structs::Frame};
use crate::host::{FrameInput, ImageUse, Receivers, SceneBuffers};
use crate::methods::FrameTimes;
use crate::scene::{Motion, Scene};
use crate::truth::{GBuffer, Reference, Tracer};
use crate::{Camera, Error, Light};
use ash::vk;
use device::LabDevice;
use glam::{DVec3, Vec2, Vec3};
use shapes::Shapes;
use std::cell::{OnceCell, RefCell};
use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;
use std::time::Instant;

/// What is looked at: camera, lights, image size and time.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// The camera.
    pub camera: Camera,
    /// The lights; at least one.
    pub lights: Vec<Light>,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Time at which animations are posed, in seconds.
    pub time_s: f64,
}

/// A failure outside the engine: a device, a method's parameter, a light a method cannot serve.
#[derive(Debug, Clone, thiserror::Error)]
#[non_exhaustive]
pub enum LabError {
    /// The engine or Vulkan failed.
    #[error(transparent)]
    Engine(#[from] Error),
    /// A method's name, key or value is not known: a mistake of the caller.
    #[error("{0}")]
    Usage(String),
    /// A method cannot serve this light or this device.
    #[error("{0}")]
    Refused(String),
}

/// What is chosen about the device.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct LabOptions {
    /// Index as `umbrage info` lists it; `None` takes the best usable one.
    pub device: Option<usize>,
    /// Turns on the validation layer with synchronization validation.
    pub validation: bool,
}

/// One device, one scene, one view.
pub struct Lab {
    timer: RefCell<Timer>,
    prepass: DepthPrepass,
    draws: Vec<MeshDraw>,
    buffers: SceneBuffers,
    /// On devices with ray queries.
    shapes: Option<Shapes>,
    _storage: Vec<Buffer>,
    scene: Scene,
    motion: Option<Motion>,
    view: View,
    tracer: OnceCell<Tracer>,
    gbuffer: OnceCell<Rc<GBuffer>>,
    /// By the light's index.
    reference: RefCell<BTreeMap<usize, Rc<Reference>>>,
    device: Arc<LabDevice>,
    gpu: Arc<Gpu>,
}

impl Lab {
    /// Opens a device, uploads the scene and readies the prepass.
    ///
    /// # Errors
    /// [`LabError::Usage`] for a device index that does not exist, [`LabError::Refused`] when no device is usable or the
    /// view has no light, [`LabError::Engine`] for everything Vulkan reports.
    pub fn new(options: &LabOptions, scene: Scene, view: View) -> Result<Self, LabError> {
        if view.lights.is_empty() {
            return Err(LabError::Refused("the view has no light; at least one is needed".into()));
        }
        let (device, gpu) = device::open(options)?;
        Self::on(device, gpu, scene, view)
    }

    pub(crate) fn on(device: Arc<LabDevice>, gpu: Arc<Gpu>, scene: Scene, view: View) -> Result<Self, LabError> {
        let (mut buffers, storage) = upload::scene(&gpu, &device, &scene)?;
        let shapes = match (&gpu.rays, &storage[..]) {
            (Some(_), [positions, _, indices, ..]) => {
                Some(Shapes::new(&gpu, &device, &scene, &mut buffers, [positions, indices])?)
            }
            _ => None,
        };
        let prepass = DepthPrepass::on(&gpu, view.size, &buffers)?;
        let draws = scene
            .meshes
            .iter()
            .map(|m| MeshDraw {
                index_count: m.index_count,
                first_index: m.first_index,
                instance_count: m.instance_count,
                first_instance: m.first_instance,
                alpha_tested: m.alpha_tested,
            })
            .collect();
        Ok(Self {
            timer: RefCell::new(Timer::new(&gpu, 32)?),
            prepass,
            draws,
            buffers,
            shapes,
            _storage: storage,
            scene,
            motion: None,
            view,
            tracer: OnceCell::new(),
            gbuffer: OnceCell::new(),
            reference: RefCell::default(),
            device,
            gpu,
        })
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The view.
    pub fn view(&self) -> &View {
        &self.view
    }

    /// Name of the device as its driver reports it.
    pub fn device_name(&self) -> String {
        self.device.report.name.clone()
    }

    /// Name and version of the driver.
    pub fn driver(&self) -> String {
        self.device.report.driver.clone()
    }

    /// Whether the device is a CPU, so that times say little about GPUs.
    pub fn device_is_cpu(&self) -> bool {
        self.device.report.kind == "cpu"
    }

    /// Whether the device has ray queries, and the lab structures for them.
    pub fn has_ray_queries(&self) -> bool {
        self.shapes.is_some()
    }

    /// Whether the device has tessellation shaders.
    pub fn has_tessellation(&self) -> bool {
        self.device.tessellation
    }

    /// Whether fragment shaders may write to buffers: the feature `fragmentStoresAndAtomics`, enabled where the device has it.
    pub fn has_fragment_stores(&self) -> bool {
        self.device.fragment_stores
    }

    /// Messages of the validation layer so far; always empty without [`LabOptions::validation`].
    pub fn validation_messages(&self) -> Vec<String> {
        self.device.messages()
    }

    /// The BVH over the scene's casters, built on first use.
    pub fn tracer(&self) -> &Tracer {
        self.tracer.get_or_init(|| Tracer::new(&self.scene))
    }

    /// A light of the view by its index.
    ///
    /// # Errors
    /// [`LabError::Usage`] for an index that the view does not have.
    pub fn light(&self, index: usize) -> Result<&Light, LabError> {
        let count = self.view.lights.len();
        let unknown = || LabError::Usage(format!("light {index} does not exist, allowed is 0 to {}", count - 1));
        self.view.lights.get(index).ok_or_else(unknown)
    }

    /// Ray-traced visibility of a light of the view at every pixel, computed on first use.
    ///
    /// # Errors
    /// As [`Lab::gbuffer`] and [`Lab::light`]; [`LabError::Refused`] when the light cannot be traced.
    pub fn reference(&self, light: usize, progress: &(dyn Fn(f64) + Sync)) -> Result<Rc<Reference>, LabError> {
        if let Some(reference) = self.reference.borrow().get(&light) {
            return Ok(reference.clone());
        }
        let gbuffer = self.gbuffer()?;
        let reference = crate::truth::reference(self.tracer(), &self.scene, &gbuffer, self.light(light)?, progress)
            .map_err(|error| LabError::Refused(format!("light {light} cannot be traced: {error}")))?;
        Ok(self.reference.borrow_mut().entry(light).or_insert_with(|| Rc::new(reference)).clone())
    }

    /// What the camera sees; the prepass runs on first use. Samples whose footprint is below 1e-5 of the scene's diagonal are
    /// moved along their view rays onto the exact surface.
    ///
    /// # Errors
    /// [`LabError::Engine`] for everything Vulkan reports.
    pub fn gbuffer(&self) -> Result<Rc<GBuffer>, LabError> {
        if let Some(gbuffer) = self.gbuffer.get() {
            return Ok(gbuffer.clone());
        }
        self.run_prepass()?;
        let words = |image: &Image| -> Result<Vec<u32>, LabError> {
            Ok(bytemuck::pod_collect_to_vec(&self.read_image(image, Access::ComputeRead, 4)?))
        };
        let (depth, normal, albedo) =
            (words(&self.prepass.depth)?, words(&self.prepass.normal)?, words(&self.prepass.albedo)?);
        let mut gbuffer =
            decode_gbuffer(&self.camera_constants()?, &self.frame_input(), self.view.size, &depth, &normal, albedo);
        crate::truth::snap(&mut gbuffer, &self.scene, || self.tracer());
        Ok(self.gbuffer.get_or_init(|| Rc::new(gbuffer)).clone())
    }

    pub(crate) fn gpu(&self) -> &Arc<Gpu> {
        &self.gpu
    }

    pub(crate) fn scene_buffers(&self) -> &SceneBuffers {
        &self.buffers
    }

    pub(crate) fn prepass(&self) -> &DepthPrepass {
        &self.prepass
    }

    pub(crate) fn draws(&self) -> &[MeshDraw] {
        &self.draws
    }

    /// Camera and origin.
    pub(crate) fn frame_input(&self) -> FrameInput {
        FrameInput::new(&self.view.camera, self.view.size, self.scene.origin)
    }

    pub(crate) fn camera_constants(&self) -> Result<Frame, LabError> {
        Ok(camera_constants(self.view.size, &self.frame_input())?)
    }

    /// Buffers filled with what each source gives.
    pub(crate) fn upload(&self, sources: &[upload::Source<'_>]) -> Result<Vec<Buffer>, LabError> {
        upload::storage(&self.gpu, &self.device, sources)
    }

    fn record_prepass(&self, cmd: vk::CommandBuffer) -> Result<(), LabError> {
        // SAFETY: the lab records its command buffer outside of rendering and waits for each submission
        Ok(unsafe { self.prepass.record(cmd, &self.frame_input(), &self.draws) }?)
    }

    /// Runs the prepass and waits.
    pub(crate) fn run_prepass(&self) -> Result<(), LabError> {
        let mut recorded = Ok(());
        self.submit(|cmd| recorded = self.record_prepass(cmd))?;
        recorded
    }

    /// Submits what `record` puts into a command buffer, waits, and returns the wall time in milliseconds.
    pub(crate) fn submit(&self, record: impl FnOnce(vk::CommandBuffer)) -> Result<f64, LabError> {
        let cmd = self.device.begin()?;
        record(cmd);
        let start = Instant::now();
        self.device.submit_and_wait(cmd)?;
        Ok(start.elapsed().as_secs_f64() * 1e3)
    }

    /// What the lab's camera saw, for an engine whose mask is copied.
    pub(crate) fn with_receivers<T>(&self, then: impl FnOnce(Receivers<'_>) -> T) -> T {
        let images = [self.prepass.images()];
        then(Receivers { size: self.view.size, images: &images, mask: ImageUse::COPIED })
    }

    /// Runs one frame: the prepass, then what `record` puts into a command buffer, with its stages timed.
    pub(crate) fn frame(&self, record: impl FnOnce(vk::CommandBuffer, &mut Timer)) -> Result<FrameTimes, LabError> {
        let mut timer = self.timer.borrow_mut();
        let mut recorded = Ok(());
        self.submit(|cmd| {
            timer.begin(cmd);
            recorded = self.record_prepass(cmd);
            timer.mark(cmd, "depth_prepass");
        })?;
        recorded?;
        let prepass_ms = timer.read()?.iter().map(|s| s.1).sum();
        let wall_ms = self.submit(|cmd| {
            timer.begin(cmd);
            record(cmd, &mut timer);
        })?;
        // what is recorded several times in a frame is one stage
        let mut stages: Vec<(&'static str, f64)> = Vec::new();
        for (name, ms) in timer.read()? {
            match stages.iter_mut().find(|(known, _)| *known == name) {
                Some((_, sum)) => *sum += ms,
                None => stages.push((name, ms)),
            }
        }
        Ok(FrameTimes { prepass_ms, ms: stages.iter().map(|s| s.1).sum(), wall_ms, stages })
    }

    /// Runs one frame of an engine that sees what the lab's camera sees.
    pub(crate) fn engine_frame(&self, engine: &mut Engine) -> Result<(FrameId, FrameTimes), LabError> {
        let input = [self.frame_input()];
        let mut recorded = Err(Error::Unsupported { what: "a frame that was not recorded".into() });
        let times = self.frame(|cmd, timer| recorded = engine.record_timed(cmd, &input, None, Some(timer)))?;
        Ok((recorded?, times))
    }

    /// Bytes of an image whose last access was `access`, `texel` bytes a texel, all layers one after the other.
    pub(crate) fn read_image(&self, image: &Image, access: Access, texel: u64) -> Result<Vec<u8>, LabError> {
        let (width, height) = (u64::from(image.extent.width), u64::from(image.extent.height));
        let bytes = width * height * u64::from(image.layers) * texel;
        let target =
            Buffer::new(&self.gpu, "image readback", bytes, vk::BufferUsageFlags::TRANSFER_DST, Memory::Readback)?;
        self.submit(|cmd| {
            let device = &self.gpu.device;
            if access != Access::TransferRead {
                sync::image(device, cmd, image, access, Access::TransferRead);
            }
            let region = [vk::BufferImageCopy::default()
                .image_subresource(vk::ImageSubresourceLayers {
                    aspect_mask: image.aspect(),
                    mip_level: 0,
                    base_array_layer: 0,
                    layer_count: image.layers,
                })
                .image_extent(vk::Extent3D { width: image.extent.width, height: image.extent.height, depth: 1 })];
            // SAFETY: the buffer holds the whole image
            unsafe {
                device.cmd_copy_image_to_buffer(
                    cmd,
                    image.raw,
                    vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
                    target.raw,
                    &region,
                )
            };
            sync::barrier(device, cmd, &[(Access::TransferWrite, Access::HostRead)]);
            if access != Access::TransferRead {
                sync::image(device, cmd, image, Access::TransferRead, access);
            }
        })?;
        Ok(target.bytes()[..bytes as usize].to_vec())
    }

    /// Contents of a buffer that compute shaders wrote.
    pub(crate) fn read_buffer(&self, buffer: &Buffer) -> Result<Vec<u8>, LabError> {
        let target = Buffer::new(
            &self.gpu,
            "buffer readback",
            buffer.size,
            vk::BufferUsageFlags::TRANSFER_DST,
            Memory::Readback,
        )?;
        self.submit(|cmd| {
            sync::barrier(&self.gpu.device, cmd, &[(Access::ComputeWrite, Access::TransferRead)]);
            let copy = [vk::BufferCopy { src_offset: 0, dst_offset: 0, size: buffer.size }];
            // SAFETY: both buffers have this size
            unsafe { self.gpu.device.cmd_copy_buffer(cmd, buffer.raw, target.raw, &copy) };
            sync::barrier(&self.gpu.device, cmd, &[(Access::TransferWrite, Access::HostRead)]);
        })?;
        Ok(target.bytes()[..buffer.size as usize].to_vec())
    }
}

/// Positions and normals from what the prepass wrote.
fn decode_gbuffer(
    frame: &Frame,
    input: &FrameInput,
    size: [u32; 2],
    depth: &[u32],
    normal: &[u32],
    albedo: Vec<u32>,
) -> GBuffer {
    let count = size[0] as usize * size[1] as usize;
    let axis = |v: [f32; 4]| DVec3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2]));
    let (corner, dx, dy) = (axis(frame.ray_corner), axis(frame.ray_dx), axis(frame.ray_dy));
    let mut g = GBuffer {
        width: size[0],
        height: size[1],
        eye: input.eye - input.origin,
        ray_steps: [dx, dy],
        position: vec![[0.0; 3]; count],
        normal: vec![[0.0; 3]; count],
        albedo,
        hit: vec![false; count],
    };
    for i in 0..count {
        let stored = f64::from(f32::from_bits(depth[i]));
        if stored <= 0.0 {
            continue;
        }
        let pixel = (f64::from(i as u32 % size[0]) + 0.5, f64::from(i as u32 / size[0]) + 0.5);
        let z = f64::from(frame.ray_corner[3]) / (stored + f64::from(frame.ray_dx[3]));
        g.position[i] = ((corner + pixel.0 * dx + pixel.1 * dy) * z).as_vec3().to_array();
        g.normal[i] = decode_normal(normal[i]).to_array();
        g.hit[i] = true;
    }
    g
}

/// Twin of `decode_normal` in `glsl/shared/receiver.glsl`.
fn decode_normal(word: u32) -> Vec3 {
    let fraction = |bits: u32| (f32::from(bits as u16 as i16) / 32767.0).clamp(-1.0, 1.0);
    let p = Vec2::new(fraction(word & 0xffff), fraction(word >> 16));
    let mut n = Vec3::new(p.x, p.y, 1.0 - p.x.abs() - p.y.abs());
    if n.z < 0.0 {
        let sign = |v: f32| if v >= 0.0 { 1.0 } else { -1.0 };
        (n.x, n.y) = ((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y));
    }
    n.normalize()
}
