//! Forward shadow mapping (Zhang 1998; book, 4.6.1): texels of a conventional map are splatted into the image and, where their depth
//! matches that of the surface seen there, they add light with a smooth kernel. What no texel reaches is in shadow.

use super::comparison::DEPTH_BIAS;
use super::izb_owner::bare;
use super::map::{self, Fits, Map, Screen, Step};
use super::uniform::{self, FIT, RESOLUTION, Uniform};
use super::{DebugPicture, FrameTimes, Method, MethodInfo, MethodSpec, Parameter, Statistics};
use crate::Filter;
use crate::gpu::structs::{ForwardCounts, ForwardSample};
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Buffer, Compute, Graphics, Shaders, Timer, set_area, spirv};
use crate::lab::{Lab, LabError};
use crate::output::Picture;
use ash::vk;
use bytemuck::Zeroable;

const SIDE: u32 = 1024;
/// Texels along a side of a block, as in `glsl/methods/forward.glsl`.
const BLOCK: u32 = 8;
/// What stands in place of the sum of a pixel that no splat reaches, though nothing is before it.
const HOLE: u32 = u32::MAX;
const HOLE_COLOR: [u8; 3] = [255, 60, 40];

const PARAMETERS: &[Parameter] = &[
    Parameter { default: "1024", ..RESOLUTION },
    FIT,
    Parameter { key: "kernel", default: "1.5", allowed: "1 to 4", meaning: "radius of the splats' kernel in texels" },
    Parameter {
        key: "stretch",
        default: "16",
        allowed: "0 to 256",
        meaning: "most that a surface's depth changes over a splat for each unit across the light: splats are cut off there",
    },
    Parameter {
        key: "fill",
        default: "false",
        allowed: "true or false",
        meaning: "whether holes, pixels that no splat reaches and nothing shadows, are lit",
    },
    Parameter {
        meaning: "how far a texel's depth may be from the pixel's surface, in texels plus a quarter of their slope, times the kernel's radius",
        ..DEPTH_BIAS
    },
];

pub(super) const INFO: MethodInfo = MethodInfo {
    name: "forward",
    source: "Zhang 1998; Eisemann et al. 2011, 4.6.1",
    summary: "The texels of one map splatted into the image, where they add light to the surfaces that they see",
    parameters: PARAMETERS,
    check: |spec| settings(spec).map(|_| ()),
    create: |spec, lab| Ok(Box::new(Forward::new(spec, lab)?)),
};

/// The method's own keys.
struct Settings {
    /// Radius of the kernel, 1/256 texel.
    reach: u32,
    stretch: f32,
    fill: bool,
}

/// Those of the map, and the method's own.
fn settings(spec: &MethodSpec) -> Result<(uniform::Settings, Settings), LabError> {
    let mut map = uniform::settings(spec, SIDE)?;
    let kernel = spec.f32_in("kernel", 1.5, 1.0..=4.0)?;
    // a border that holds the kernel; nothing is looked up with it
    map.comparison.filter = Filter::Pcf { taps: 2 * kernel.ceil() as u32 };
    map.comparison.bias_texels *= kernel;
    let own = Settings {
        reach: (256.0 * kernel) as u32,
        stretch: spec.f32_in("stretch", 16.0, 0.0..=256.0)?,
        fill: spec.one_of("fill", "false", &["true", "false"])? == "true",
    };
    Ok((map, own))
}

/// The splats of one light.
struct Splats {
    /// [`ForwardCounts`], then the blocks to splat.
    list: Buffer,
    /// A [`ForwardSample`] for each pixel.
    samples: Buffer,
    /// Weights of the texels that reached a pixel, or [`HOLE`].
    sums: Buffer,
    place: Compute,
    select: Compute,
    /// Blocks of a map.
    groups: [u32; 3],
    draw: Graphics,
    resolve: Compute,
}

impl Splats {
    fn new(lab: &Lab, screen: &Screen, map: &Map, settings: &Settings) -> Result<Self, LabError> {
        let (gpu, shape) = (lab.gpu(), map.shape());
        let [width, height] = lab.view().size;
        let pixels = u64::from(width) * u64::from(height);
        let storage = |name, bytes, usage| Buffer::storage(gpu, name, bytes, usage);
        let across = shape.side.div_ceil(BLOCK);
        let blocks = u64::from(across) * u64::from(across) * u64::from(shape.layers);
        let header = size_of::<ForwardCounts>() as u64;
        let list = storage("splatted blocks", header + 4 * blocks, vk::BufferUsageFlags::INDIRECT_BUFFER)?;
        let samples =
            storage("forward samples", size_of::<ForwardSample>() as u64 * pixels, vk::BufferUsageFlags::empty())?;
        let sums = storage("sums of splats", 4 * pixels, vk::BufferUsageFlags::empty())?;
        let image = Binding::Sampled(map.image());
        let read = map.samples(screen);
        let (frame, fits) = (read[0], Binding::Storage(map.fits()));
        let [listed, sampled, summed] = [&list, &samples, &sums].map(Binding::Storage);
        let texels = [frame, Binding::Uniform(map.light()), fits, image, listed];
        let position = map.fitted().position();
        let Settings { reach, stretch, fill, .. } = *settings;
        let texel_constants = [0, position, reach, stretch.to_bits()];
        let compute = |name, words: &[u8], bindings: &[Binding<'_>], constants: &[u32]| {
            Compute::new(gpu, name, words, bindings, constants, 0)
        };
        let (vertex, fragment) = (spirv!("methods/forward_splat.vert"), spirv!("methods/forward_splat.frag"));
        let shaders = Shaders { vertex, tessellation: None, fragment: Some(fragment), constants: &texel_constants };
        Ok(Self {
            place: compute(
                "forward_place",
                spirv!("methods/forward_place.comp"),
                &[&read[..], &[fits, image, sampled, summed]].concat(),
                &[shape.layers, position, reach],
            )?,
            select: compute("forward_select", spirv!("methods/forward_select.comp"), &texels, &texel_constants)?,
            groups: [across, across, shape.layers],
            draw: Graphics::new(
                gpu,
                "forward_splat",
                &shaders,
                &[&texels[..], &[sampled, summed]].concat(),
                &bare(lab.scene_buffers()),
            )?,
            resolve: compute(
                "forward_resolve",
                spirv!("methods/forward_resolve.comp"),
                &[frame, image, listed, sampled, summed, Binding::StorageImage(map.visibility_image())],
                &[0, 0, reach, fill.into()],
            )?,
            list,
            samples,
            sums,
        })
    }

    /// An empty list; the caller orders what comes before and after.
    fn reset(&self, device: &ash::Device, cmd: vk::CommandBuffer) {
        sync::barrier(device, cmd, &[(Access::IndirectRead, Access::TransferWrite)]);
        let none = ForwardCounts { instances: 1, ..ForwardCounts::zeroed() };
        // SAFETY: the command buffer is recording; the list begins with its counts
        unsafe { device.cmd_update_buffer(cmd, self.list.raw, 0, bytemuck::bytes_of(&none)) };
    }

    fn splat(&self, device: &ash::Device, cmd: vk::CommandBuffer, [width, height]: [u32; 2]) {
        let area = vk::Rect2D { offset: vk::Offset2D::default(), extent: vk::Extent2D { width, height } };
        // SAFETY: the command buffer is recording; buffers and images outlive the submission
        unsafe {
            device.cmd_begin_rendering(cmd, &vk::RenderingInfo::default().render_area(area).layer_count(1));
            set_area(device, cmd, area);
            self.draw.bind(cmd);
            device.cmd_draw_indirect(cmd, self.list.raw, 0, 1, 0);
            device.cmd_end_rendering(cmd);
        }
    }

    fn counts(&self, lab: &Lab) -> Result<ForwardCounts, LabError> {
        Ok(bytemuck::pod_read_unaligned(&lab.read_buffer(&self.list)?[..size_of::<ForwardCounts>()]))
    }

    fn sums(&self, lab: &Lab) -> Result<Vec<u32>, LabError> {
        let [width, height] = lab.view().size;
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(&lab.read_buffer(&self.sums)?);
        // what is allocated may be longer
        Ok(words[..(width * height) as usize].to_vec())
    }
}

struct Forward {
    base: Uniform,
    /// One for each light.
    splats: Vec<Splats>,
}

impl Forward {
    fn new(spec: &MethodSpec, lab: &Lab) -> Result<Self, LabError> {
        super::fragment_stores(spec, lab)?;
        let (map, settings) = settings(spec)?;
        let screen = Screen::comparing(lab, &map.comparison)?;
        let base = Uniform::new(spec, lab, map, screen)?;
        let splats = |map| Splats::new(lab, &base.screen, map, &settings);
        let splats = base.maps.iter().map(splats).collect::<Result<_, _>>()?;
        Ok(Self { base, splats })
    }
}

impl Method for Forward {
    fn frame(&mut self, lab: &Lab) -> Result<FrameTimes, LabError> {
        use Access::*;
        let given = self.base.given(lab)?;
        let camera = lab.camera_constants()?;
        let device = &lab.gpu().device;
        let size = lab.view().size;
        let groups = [size[0].div_ceil(8), size[1].div_ceil(8), 1];
        let (screen, maps, splats) = (&self.base.screen, &self.base.maps, &self.splats);
        let reset = |step, cmd, _: &mut Timer| {
            if step == Step::Reset {
                splats.iter().for_each(|splats| splats.reset(device, cmd));
            }
        };
        lab.frame(|cmd, timer| {
            map::record_fits((lab, &camera), (cmd, timer), screen, maps, &given, reset);
            maps.iter().for_each(|map| map.draw(lab, cmd));
            timer.mark(cmd, "map");
            for splats in splats {
                splats.place.dispatch(cmd, &(), groups);
                splats.select.dispatch(cmd, &(), splats.groups);
            }
            let selected = [(ComputeWrite, IndirectRead), (ComputeWrite, GraphicsRead), (ComputeWrite, FragmentWrite)];
            sync::barrier(device, cmd, &selected);
            timer.mark(cmd, "select");
            splats.iter().for_each(|splats| splats.splat(device, cmd, size));
            sync::barrier(device, cmd, &[(FragmentWrite, ComputeWrite)]);
            timer.mark(cmd, "splat");
            for (map, splats) in maps.iter().zip(splats) {
                sync::discard(device, cmd, map.visibility_image(), TransferRead, StorageImage);
                splats.resolve.dispatch(cmd, &(), groups);
                sync::image(device, cmd, map.visibility_image(), StorageImage, TransferRead);
            }
            timer.mark(cmd, "resolve");
        })
    }

    of_maps!(self, INFO.name, &self.base.screen, &self.base.maps);

    fn memory(&self) -> Vec<(&'static str, u64)> {
        let mut memory = self.base.memory();
        let sum = |bytes: fn(&Splats) -> u64| self.splats.iter().map(bytes).sum();
        memory.extend([("samples", sum(|s| s.samples.size + s.sums.size)), ("list", sum(|s| s.list.size))]);
        memory
    }

    fn statistics(&mut self, lab: &Lab) -> Result<Statistics, LabError> {
        let mut statistics = self.base.statistics(lab)?;
        let (mut blocks, mut holes) = (0, 0);
        for splats in &self.splats {
            let counts = splats.counts(lab)?;
            blocks += u64::from(counts.vertices / (6 * BLOCK * BLOCK));
            holes += u64::from(counts.holes);
        }
        statistics.counters.extend([("blocks", blocks), ("holes", holes)]);
        Ok(statistics)
    }

    fn debug_pictures(&mut self, lab: &Lab) -> Result<Vec<DebugPicture>, LabError> {
        let [width, height] = lab.view().size;
        let Some(splats) = self.splats.first() else { return Ok(Vec::new()) };
        let lit = self.base.maps[0].visibility(lab)?;
        let mut picture = Picture::filled(width, height, [0; 3]);
        for (i, (sum, lit)) in (0u32..).zip(splats.sums(lab)?.into_iter().zip(lit)) {
            let color = if sum == HOLE { HOLE_COLOR } else { [(40.0 + 215.0 * lit) as u8; 3] };
            picture.fill(i % width, i / width, 1, 1, color);
        }
        Ok(vec![DebugPicture { name: "holes", width, height, rgb: picture.rgb }])
    }
}

/// The method with what its last frame did for the view's first light, for tests.
#[doc(hidden)]
pub struct ForwardStage(Forward);

impl ForwardStage {
    /// As [`super::create`], without its checks.
    ///
    /// # Errors
    /// As [`super::create`].
    pub fn new(spec: &MethodSpec, lab: &Lab) -> Result<Self, LabError> {
        Forward::new(spec, lab).map(Self)
    }

    /// The method itself.
    pub fn method(&mut self) -> &mut dyn Method {
        &mut self.0
    }

    /// Where the map has the surface under each pixel.
    ///
    /// # Errors
    /// [`LabError::Engine`] for everything Vulkan reports.
    pub fn samples(&self, lab: &Lab) -> Result<Vec<ForwardSample>, LabError> {
        let bytes = lab.read_buffer(&self.0.splats[0].samples)?;
        let [width, height] = lab.view().size;
        Ok(bytemuck::pod_collect_to_vec(&bytes[..(width * height) as usize * size_of::<ForwardSample>()]))
    }

    /// Weights of the texels that reached each pixel; `u32::MAX` for holes.
    ///
    /// # Errors
    /// As [`Self::samples`].
    pub fn sums(&self, lab: &Lab) -> Result<Vec<u32>, LabError> {
        self.0.splats[0].sums(lab)
    }

    /// Depths of the map, layer by layer; nearest is greatest, 0 where nothing is.
    ///
    /// # Errors
    /// As [`Self::samples`].
    pub fn depths(&self, lab: &Lab) -> Result<Vec<f32>, LabError> {
        self.0.base.maps[0].depths(lab)
    }
}
