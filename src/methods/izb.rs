//! Alias-free shadow maps, irregular z-buffers (Aila, Laine 2004; Johnson et al. 2005; book, 4.5): no texels are compared. The
//! visible samples are put into lists by texel of a grid in light space, casters are drawn conservatively over that grid, and
//! each is tested exactly against the samples of every texel that it touches.

use super::map::{self, Fitted, Given, Screen};
use super::{DebugPicture, FrameTimes, Masks, Method, MethodInfo, MethodSpec, Parameter, Statistics, map_light};
use crate::Light;
use crate::config::BEND;
use crate::engine::constants::ray_start;
use crate::engine::depth_prepass::MeshDraw;
use crate::engine::exact::hit_bindings;
use crate::gpu::structs::Slices;
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Buffer, Compute, Graphics, GraphicsState, Image, Shaders, set_area, spirv};
use crate::host::SceneBuffers;
use crate::lab::{Lab, LabError};
use ash::vk;
use bytemuck::Zeroable;

const PARAMETERS: &[Parameter] = &[
    Parameter {
        key: "resolution",
        default: "1024",
        allowed: "16 to 4096",
        meaning: "side of the grid in texels, which changes the time but not the image; a cube's grids share the same number of texels",
    },
    Parameter {
        key: "samples",
        default: "1",
        allowed: "1, 4, 8 or 16",
        meaning: "samples a pixel: visibility is the share of them that the light reaches",
    },
    Parameter {
        key: "own",
        default: "id",
        allowed: "id or offset",
        meaning: "what keeps triangles from shadowing their own samples: their numbers, which takes another camera pass, or the start of rays off the surface alone",
    },
];

pub(super) const INFO: MethodInfo = MethodInfo {
    name: "izb",
    source: "Aila, Laine 2004; Johnson et al. 2005; Sintorn et al. 2008; Eisemann et al. 2011, 4.5",
    summary: "Every visible sample in a list of a light-space grid, tested exactly against the casters drawn over it",
    parameters: PARAMETERS,
    check: |spec| settings(spec).map(|_| ()),
    create: |spec, lab| Ok(Box::new(Izb::new(spec, lab)?)),
};

#[derive(Clone, Copy)]
struct Settings {
    resolution: u32,
    samples: u32,
    /// Whether the triangle under each pixel is found.
    own: bool,
}

fn settings(spec: &MethodSpec) -> Result<Settings, LabError> {
    Ok(Settings {
        resolution: spec.u32_in("resolution", 1024, 16..=4096)?,
        samples: spec.one_of("samples", "1", &["1", "4", "8", "16"])?.parse().unwrap_or(1),
        own: spec.one_of("own", "id", &["id", "offset"])? == "id",
    })
}

/// Finds the triangle under each pixel, and puts samples of small pixels exactly onto it.
struct Owners {
    /// Instance, and triangle of the scene + 1.
    image: Image,
    depth: Image,
    /// Without and with alpha test.
    draws: [Graphics; 2],
    snap: Compute,
}

impl Owners {
    fn new(lab: &Lab, screen: &Screen) -> Result<Self, LabError> {
        use vk::ImageUsageFlags as I;
        let (gpu, scene) = (lab.gpu(), lab.scene_buffers());
        let image = map::screen_image(lab, "owners", vk::Format::R32G32_UINT, I::COLOR_ATTACHMENT | I::SAMPLED)?;
        let depth = map::screen_image(lab, "owners' depth", vk::Format::D32_SFLOAT, I::DEPTH_STENCIL_ATTACHMENT)?;
        let bindings =
            [&[Binding::Uniform(&screen.frame)], &hit_bindings(scene)[..], &[Binding::External(scene.indices)]]
                .concat();
        let [stride, offset, format] = scene.position_layout.words();
        let state = GraphicsState {
            colors: &[vk::Format::R32G32_UINT],
            depth: true,
            depth_compare: vk::CompareOp::GREATER_OR_EQUAL,
            ..bare(scene)
        };
        let draw = |masked: bool| {
            let (vertex, fragment) = (spirv!("methods/izb_owner.vert"), spirv!("methods/izb_owner.frag"));
            let constants = &[stride, offset, format, u32::from(masked)];
            let shaders = Shaders { vertex, fragment: Some(fragment), constants };
            Graphics::new(gpu, "izb_owner", &shaders, &bindings, &state)
        };
        let seen = [Binding::Sampled(&image), Binding::StorageImage(&screen.receivers.depth)];
        let bindings = [&bindings[..], &seen].concat();
        let snap = spirv!("methods/izb_snap.comp");
        Ok(Self {
            draws: [draw(false)?, draw(true)?],
            snap: Compute::new(gpu, "izb_snap", snap, &bindings, &[stride, offset, format], 0)?,
            image,
            depth,
        })
    }

    /// After the receivers were written.
    fn record(&self, lab: &Lab, cmd: vk::CommandBuffer, screen: &Screen, groups: [u32; 3]) {
        use Access::*;
        let device = &lab.gpu().device;
        sync::discard(device, cmd, &self.image, LookupRead, ColorAttachment);
        sync::discard(device, cmd, &self.depth, DepthAttachment, DepthAttachment);
        let target = |image: &Image, image_layout, store_op| {
            vk::RenderingAttachmentInfo::default()
                .image_view(image.view)
                .image_layout(image_layout)
                .load_op(vk::AttachmentLoadOp::CLEAR)
                .store_op(store_op)
        };
        // clear values are all zero: depth 0 is the far end
        use vk::AttachmentStoreOp as S;
        let colors = [target(&self.image, vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL, S::STORE)];
        let depth = target(&self.depth, vk::ImageLayout::DEPTH_ATTACHMENT_OPTIMAL, S::DONT_CARE);
        let info = vk::RenderingInfo::default().color_attachments(&colors).depth_attachment(&depth);
        let seen = |alpha_tested| lab.draws().iter().filter(move |d| d.alpha_tested == alpha_tested);
        draw(lab, cmd, self.image.extent, info, &self.draws, seen);
        sync::image(device, cmd, &self.image, ColorAttachment, LookupRead);
        sync::image(device, cmd, &screen.receivers.depth, ComputeRead, StorageImage);
        self.snap.dispatch(cmd, &(), groups);
        sync::image(device, cmd, &screen.receivers.depth, StorageImage, ComputeRead);
    }
}

/// Grid and lists of one light.
struct Grid {
    fitted: Fitted,
    side: u32,
    /// First sample of each list.
    heads: Buffer,
    /// Place and successor of each sample.
    listed: Buffer,
    /// A bit for each sample of a pixel.
    shadowed: Buffer,
    visibility: Image,
    lists: Compute,
    /// Without and with alpha test, for each layer.
    draws: Vec<[Graphics; 2]>,
    resolve: Compute,
}

impl Grid {
    fn new(
        spec: &MethodSpec,
        lab: &Lab,
        (screen, owners): (&Screen, Option<&Owners>),
        light: &Light,
        settings: Settings,
    ) -> Result<Self, LabError> {
        let Settings { resolution, samples, .. } = settings;
        let (gpu, kind, layers) = (lab.gpu(), map_light::kind(light), map_light::layers(light));
        let side = (f64::from(resolution) / f64::from(layers).sqrt()) as u32;
        let [width, height] = lab.view().size;
        let pixels = u64::from(width) * u64::from(height);
        let storage = |name, bytes: u64| {
            let limit = u64::from(gpu.limits.max_storage_buffer_range);
            if bytes > limit {
                return Err(LabError::Refused(format!(
                    "'{spec}': {name} need {bytes} bytes, this device allows {limit}"
                )));
            }
            Ok(Buffer::storage(gpu, name, bytes, vk::BufferUsageFlags::empty())?)
        };
        let heads = storage("heads of lists", 4 * u64::from(layers) * u64::from(side).pow(2))?;
        let listed = storage("listed samples", 16 * pixels * u64::from(samples))?;
        let shadowed = storage("shadowed samples", 4 * pixels)?;
        // rounding keeps every sample inside
        let fitted = Fitted::new(lab, screen, kind, [side, layers, 1], 0.0, samples)?;
        let usage = vk::ImageUsageFlags::STORAGE | vk::ImageUsageFlags::TRANSFER_SRC;
        let visibility = map::screen_image(lab, "visibility", vk::Format::R32_SFLOAT, usage)?;
        let own = [Binding::Storage(&heads), Binding::Storage(&listed), Binding::Storage(&shadowed)];
        let (scene, fits, position) = (lab.scene_buffers(), Binding::Storage(&fitted.fits), fitted.position());
        let seen = fitted.samples(screen);
        let lists = [&seen[..], &[fits], &own].concat();
        let drawn = [&[seen[0], seen[3], fits], &hit_bindings(scene)[..], &[Binding::External(scene.indices)], &own];
        let owned = owners.map(|owners| Binding::Sampled(&owners.image)).unwrap_or(seen[2]);
        let drawn = [&drawn.concat()[..], &[owned]].concat();
        let draw = |layer: u32, masked: bool| {
            let [stride, offset, format] = scene.position_layout.words();
            let constants = [
                layer,
                position,
                side,
                stride,
                offset,
                format,
                samples,
                u32::from(masked),
                u32::from(owners.is_some()),
            ];
            let (vertex, fragment) = (spirv!("methods/izb_casters.vert"), spirv!("methods/izb_casters.frag"));
            let shaders = Shaders { vertex, fragment: Some(fragment), constants: &constants };
            Graphics::new(gpu, "izb_casters", &shaders, &drawn, &bare(scene))
        };
        Ok(Self {
            lists: Compute::new(
                gpu,
                "izb_lists",
                spirv!("methods/izb_lists.comp"),
                &lists,
                &[layers, position, side, 0, 0, 0, samples, BEND.to_bits()],
                0,
            )?,
            draws: (0..layers).map(|l| Ok([draw(l, false)?, draw(l, true)?])).collect::<Result<_, LabError>>()?,
            resolve: Compute::new(
                gpu,
                "izb_resolve",
                spirv!("methods/izb_resolve.comp"),
                &[seen[0], own[2], Binding::StorageImage(&visibility)],
                &[samples],
                0,
            )?,
            fitted,
            side,
            heads,
            listed,
            shadowed,
            visibility,
        })
    }

    fn record(&self, lab: &Lab, cmd: vk::CommandBuffer) {
        let extent = vk::Extent2D { width: self.side, height: self.side };
        for pipelines in &self.draws {
            draw(lab, cmd, extent, vk::RenderingInfo::default(), pipelines, |m| map::casters(lab, Some(m)));
        }
    }

    /// Samples in each list of the last frame, by layer, row and texel.
    fn lengths(&self, lab: &Lab) -> Result<Vec<u32>, LabError> {
        let gpu = lab.gpu();
        let count = (self.heads.size / 4) as u32;
        let lengths = Buffer::storage(gpu, "lengths of lists", self.heads.size, vk::BufferUsageFlags::empty())?;
        let bindings = [&self.heads, &self.listed, &lengths].map(Binding::Storage);
        let pass = Compute::new(gpu, "izb_lengths", spirv!("methods/izb_lengths.comp"), &bindings, &[count], 0)?;
        lab.submit(|cmd| pass.dispatch(cmd, &(), [1024, count.div_ceil(64 * 1024), 1]))?;
        Ok(bytemuck::pod_collect_to_vec(&lab.read_buffer(&lengths)?))
    }
}

impl AsRef<Fitted> for Grid {
    fn as_ref(&self) -> &Fitted {
        &self.fitted
    }
}

/// Draws with a pipeline for what is not alpha tested and one for what is.
fn draw<'a, D: Iterator<Item = &'a MeshDraw>>(
    lab: &Lab,
    cmd: vk::CommandBuffer,
    extent: vk::Extent2D,
    info: vk::RenderingInfo<'_>,
    pipelines: &[Graphics; 2],
    draws: impl Fn(bool) -> D,
) {
    let device = &lab.gpu().device;
    let area = vk::Rect2D { offset: vk::Offset2D::default(), extent };
    // SAFETY: the command buffer is recording; buffers and images outlive the submission
    unsafe {
        device.cmd_begin_rendering(cmd, &info.render_area(area).layer_count(1));
        set_area(device, cmd, area);
        for (pipeline, alpha_tested) in pipelines.iter().zip([false, true]) {
            pipeline.bind(cmd);
            for d in draws(alpha_tested) {
                device.cmd_draw(cmd, d.index_count, d.instance_count, d.first_index, d.first_instance);
            }
        }
        device.cmd_end_rendering(cmd);
    }
}

/// Vertices are fetched by the shader, and nothing but buffers is written.
fn bare(scene: &SceneBuffers) -> GraphicsState<'static> {
    GraphicsState { positions: None, depth: false, ..GraphicsState::casters(scene.position_layout, false) }
}

pub(super) struct Izb {
    screen: Screen,
    owners: Option<Owners>,
    /// One for each light.
    grids: Vec<Grid>,
}

impl Izb {
    pub(super) fn new(spec: &MethodSpec, lab: &Lab) -> Result<Self, LabError> {
        let settings = settings(spec)?;
        if !lab.has_fragment_stores() {
            return Err(LabError::Refused(format!(
                "'{spec}' needs the feature fragmentStoresAndAtomics, which device '{}' does not have",
                lab.device_name()
            )));
        }
        let screen = Screen::new(lab)?;
        let owners = settings.own.then(|| Owners::new(lab, &screen)).transpose()?;
        let lights = lab.view().lights.iter();
        let grid = |light| Grid::new(spec, lab, (&screen, owners.as_ref()), light, settings);
        let grids = lights.map(grid).collect::<Result<_, _>>()?;
        Ok(Self { screen, owners, grids })
    }
}

impl Method for Izb {
    fn frame(&mut self, lab: &Lab) -> Result<FrameTimes, LabError> {
        use Access::*;
        map::check_lights(lab, &self.grids)?;
        let given = |light: &Light| {
            Ok(Given { light: map_light::constants(light, lab, 0.0)?, fits: None, slices: Slices::zeroed() })
        };
        let given = lab.view().lights.iter().map(given).collect::<Result<Vec<_>, LabError>>()?;
        let mut camera = lab.camera_constants()?;
        camera.rule[3] = ray_start(lab.scene_buffers());
        let device = &lab.gpu().device;
        let [width, height] = lab.view().size;
        let groups = [width.div_ceil(8), height.div_ceil(8), 1];
        let steps = |step, cmd| match step {
            map::Step::Reset => self.grids.iter().for_each(|grid| {
                // SAFETY: the command buffer is recording; the map's own commands wait for the last frame and for this
                unsafe { device.cmd_fill_buffer(cmd, grid.heads.raw, 0, vk::WHOLE_SIZE, 0) }
            }),
            map::Step::Slice => {
                self.owners.iter().for_each(|owners| owners.record(lab, cmd, &self.screen, groups));
            }
            map::Step::Fitted => {}
        };
        lab.frame(|cmd, timer| {
            map::record_fits((lab, &camera), (cmd, timer), &self.screen, &self.grids, &given, steps);
            self.grids.iter().for_each(|grid| grid.lists.dispatch(cmd, &(), groups));
            sync::barrier(device, cmd, &[(ComputeWrite, FragmentWrite)]);
            timer.mark(cmd, "lists");
            self.grids.iter().for_each(|grid| grid.record(lab, cmd));
            sync::barrier(device, cmd, &[(FragmentWrite, ComputeWrite)]);
            timer.mark(cmd, "casters");
            for grid in &self.grids {
                sync::discard(device, cmd, &grid.visibility, TransferRead, StorageImage);
                grid.resolve.dispatch(cmd, &(), groups);
                sync::image(device, cmd, &grid.visibility, StorageImage, TransferRead);
            }
            timer.mark(cmd, "resolve");
        })
    }

    fn visibility(&mut self, lab: &Lab, light: usize) -> Result<Vec<f32>, LabError> {
        let grid = super::of_light(&self.grids, INFO.name, light)?;
        Ok(bytemuck::pod_collect_to_vec(&lab.read_image(&grid.visibility, Access::TransferRead, 4)?))
    }

    fn masks(&self) -> Option<Masks<'_>> {
        Some(Masks { images: self.grids.iter().map(|grid| &grid.visibility).collect(), bits: 32 })
    }

    fn memory(&self) -> Vec<(&'static str, u64)> {
        let sum = |bytes: fn(&Grid) -> u64| self.grids.iter().map(bytes).sum::<u64>();
        let owners = self.owners.as_ref().map_or(0, |owners| owners.image.bytes + owners.depth.bytes);
        vec![
            ("lists", sum(|g| g.heads.size + g.listed.size + g.shadowed.size)),
            ("screen", self.screen.receivers.bytes() + owners + sum(|g| g.visibility.bytes)),
            ("other", self.screen.frame.size + sum(|g| g.fitted.bytes())),
        ]
    }

    fn statistics(&mut self, lab: &Lab) -> Result<Statistics, LabError> {
        let mut outside = 0;
        let mut lengths = Vec::new();
        for grid in &self.grids {
            outside += grid.fitted.outside(lab)?;
            lengths.extend(grid.lengths(lab)?);
        }
        let counters = vec![
            ("samples", lengths.iter().map(|&n| u64::from(n)).sum()),
            ("lists", lengths.iter().filter(|&&n| n > 0).count() as u64),
            ("longest_list", lengths.iter().copied().max().unwrap_or(0).into()),
            ("outside", outside),
        ];
        Ok(Statistics { counters, ..Statistics::default() })
    }

    fn debug_pictures(&mut self, lab: &Lab) -> Result<Vec<DebugPicture>, LabError> {
        let Some(grid) = self.grids.first() else { return Ok(Vec::new()) };
        let lengths = grid.lengths(lab)?;
        let level = |n: &u32| if *n == 0 { f32::NAN } else { (*n as f32).log2() };
        let values: Vec<f32> = lengths.iter().map(level).collect();
        let picture = crate::output::levels(grid.side, (values.len() / grid.side as usize) as u32, &values)
            .map_err(|error| LabError::Refused(error.to_string()))?;
        Ok(vec![DebugPicture { name: "list_length", width: picture.width, height: picture.height, rgb: picture.rgb }])
    }
}
