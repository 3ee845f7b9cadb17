//! What the methods that draw fitted maps share: the layers of one light's map with their passes, and a frame of them.

use super::comparison::{BiasKind, Comparison};
use super::izb_owner::Owners;
use super::map_fit::{ANGLES, least_area};
use super::map_light::Kind;
use super::polygon_ids::PolygonIds;
use super::silhouette_edges::Edges;
use super::silhouette_map::SilhouetteMap;
use super::tiles::Tiles;
use super::{DebugPicture, Masks, MethodSpec, Statistics, map_light};
use crate::config::BEND;
use crate::engine::depth_prepass::MeshDraw;
use crate::engine::gradient::{Gradient, Receivers};
use crate::gpu::structs::{Fit, Frame, MapLight, Slices};
use crate::gpu::sync::{self, Access};
use crate::gpu::{
    Binding, Buffer, Compute, Gpu, Graphics, GraphicsState, Image, ImageSpec, Memory, Shaders, Timer, set_area, spirv,
};
use crate::lab::{Lab, LabError};
use crate::{Cull, Filter, Light};
use ash::vk;
use bytemuck::Zeroable;
use glam::DVec2;
use std::sync::Arc;

/// What the maps of all lights share: camera constants and the receivers' planes.
pub(super) struct Screen {
    pub(super) frame: Buffer,
    pub(super) receivers: Receivers,
    gradient: Gradient,
    size: [u32; 2],
    /// Where maps hold silhouettes too.
    edges: Option<Edges>,
    /// The triangle under each pixel, where comparisons ask for it.
    owners: Option<Owners>,
}

impl Screen {
    pub(super) fn new(lab: &Lab) -> Result<Self, LabError> {
        let gpu = lab.gpu();
        let frame = constants_buffer(gpu, "frame constants", size_of::<Frame>())?;
        let receivers = Receivers::new(gpu, lab.view().size)?;
        let gradient = Gradient::new(gpu, Binding::Uniform(&frame), &lab.prepass().images(), &receivers)?;
        Ok(Self { frame, receivers, gradient, size: lab.view().size, edges: None, owners: None })
    }

    /// With what a comparison reads of each pixel.
    pub(super) fn comparing(lab: &Lab, comparison: &Comparison) -> Result<Self, LabError> {
        if comparison.bias == BiasKind::Ids { Self::with_owners(lab) } else { Self::new(lab) }
    }

    /// With the triangle under each pixel.
    pub(super) fn with_owners(lab: &Lab) -> Result<Self, LabError> {
        let screen = Self::new(lab)?;
        Ok(Self { owners: Some(Owners::new(lab, &screen)?), ..screen })
    }

    /// For maps that hold silhouettes too.
    pub(super) fn with_edges(lab: &Lab, comparison: &Comparison) -> Result<Self, LabError> {
        Ok(Self { edges: Some(Edges::new(lab)?), ..Self::comparing(lab, comparison)? })
    }

    /// The triangle under each pixel, where it is found.
    pub(super) fn owners(&self) -> Option<&Owners> {
        self.owners.as_ref()
    }

    /// Device memory of what all pixels have, in bytes.
    pub(super) fn bytes(&self) -> u64 {
        self.receivers.bytes() + self.owners.as_ref().map_or(0, Owners::bytes)
    }

    /// The scene's edges where maps hold silhouettes too.
    pub(super) fn edges(&self) -> Option<&Edges> {
        self.edges.as_ref()
    }

    /// Workgroups of a pass in which a thread walks down 32 pixels of a column.
    pub(super) fn columns(&self) -> [u32; 3] {
        [self.size[0].div_ceil(64), self.size[1].div_ceil(32), 1]
    }
}

fn constants_buffer(gpu: &Arc<Gpu>, name: &str, size: usize) -> Result<Buffer, LabError> {
    use vk::BufferUsageFlags as U;
    let usage = U::UNIFORM_BUFFER | U::TRANSFER_DST | U::TRANSFER_SRC;
    Ok(Buffer::new(gpu, name, size as u64, usage, Memory::Device)?)
}

pub(super) fn screen_image(
    lab: &Lab,
    name: &str,
    format: vk::Format,
    usage: vk::ImageUsageFlags,
) -> Result<Image, LabError> {
    let [width, height] = lab.view().size;
    Ok(Image::new(lab.gpu(), name, &ImageSpec { format, width, height, layers: 0, usage })?)
}

/// Layers of one light's map: squares of `side` texels.
pub(super) struct Shape {
    pub(super) side: u32,
    pub(super) layers: u32,
    /// Whether the layers are tiles, which the method's own shaders place and pick: see [`Tiles`].
    pub(super) tiled: bool,
    /// Share of a layer's slice at whose end it gives way to the next; 0: none.
    pub(super) blend: f32,
    pub(super) comparison: Comparison,
}

impl Shape {
    /// The fit of a layer to what it must hold.
    pub(super) fn fit(&self, points: &[DVec2]) -> Fit {
        least_area(points, self.side.into(), self.border().into())
    }

    /// What is fitted to samples: each layer, or what all tiles lie in.
    pub(super) fn fitted(&self) -> u32 {
        if self.tiled { 1 } else { self.layers }
    }

    /// Texels around the samples that a layer holds too.
    pub(super) fn border(&self) -> u32 {
        // rounding keeps every sample inside
        let filter = if self.comparison.filter == Filter::Hard { 0 } else { self.comparison.filter.reach() };
        1 + filter + self.comparison.search
    }
}

/// Moments of a frame at which a method may record passes of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Step {
    /// Transfers, before anything else.
    Reset,
    /// Before the maps are fitted to the samples.
    Slice,
    /// After that; what is written is ordered before compute shaders.
    Fitted,
    /// Before the maps are drawn, fitted or given; what is written is ordered before they are.
    Warp,
}

/// What the CPU gives for a frame of one light.
pub(super) struct Given {
    pub(super) light: MapLight,
    /// One for each layer; `None` fits each to its samples.
    pub(super) fits: Option<Vec<Fit>>,
    pub(super) slices: Slices,
}

fn samples_of<'a>(screen: &'a Screen, light: &'a Buffer, slices: &'a Buffer) -> [Binding<'a>; 5] {
    [
        Binding::Uniform(&screen.frame),
        Binding::Sampled(&screen.receivers.depth),
        Binding::Sampled(&screen.receivers.planes),
        Binding::Uniform(light),
        Binding::Storage(slices),
    ]
}

/// The triangle under each pixel, or what shaders do not read.
fn owners_of(screen: &Screen) -> Binding<'_> {
    Binding::Sampled(screen.owners().map_or(&screen.receivers.planes, |owners| &owners.image))
}

/// What drawing reads: `glsl/methods/map_place.glsl`, pairs, and what tests of fragments need.
fn caster_bindings<'a>(lab: &Lab, light: &'a Buffer, fits: &'a Buffer, pairs: Binding<'a>) -> [Binding<'a>; 6] {
    let scene = lab.scene_buffers();
    [
        Binding::Uniform(light),
        Binding::Storage(fits),
        Binding::External(scene.instances),
        pairs,
        Binding::External(scene.materials),
        Binding::External(scene.texels),
    ]
}

/// Constants of `glsl/methods/map_lookup.glsl`.
fn lookup_constants(shape: &Shape, position: u32, silhouettes: bool) -> [u32; 9] {
    let Comparison { bias, filter, centred, .. } = shape.comparison;
    let [kind, taps] = filter.words();
    let (blend, tiled) = (shape.blend.to_bits(), shape.tiled.into());
    [shape.fitted(), position, kind, taps, bias as u32, blend, tiled, silhouettes.into(), centred.into()]
}

/// What draws casters into a map without tiles otherwise than by straight edges where the fit has them.
pub(super) struct Warped {
    /// Without and with alpha test.
    pub(super) draws: [Graphics; 2],
    /// Whether the vertex shader fetches vertices itself, six a triangle.
    pub(super) fetches: bool,
    /// Where the fit alone does not tell where a sample lies.
    pub(super) lookup: Option<Compute>,
}

/// What is fitted to the visible samples of one light.
pub(super) struct Fitted {
    kind: Kind,
    side: u32,
    border: u32,
    /// Fits to samples.
    count: u32,
    light: Buffer,
    bounds: Buffer,
    pub(super) fits: Buffer,
    slices: Buffer,
    measure: Compute,
    choose: Compute,
}

impl Fitted {
    /// `sizes`: side of a layer in texels, layers, fits to samples, and texels around the samples that a fit holds too; `blend`:
    /// as [`Shape::blend`]; `samples`: of a pixel, where a fit holds more than its middle.
    pub(super) fn new(
        lab: &Lab,
        screen: &Screen,
        kind: Kind,
        [side, layers, count, border]: [u32; 4],
        blend: f32,
        samples: u32,
    ) -> Result<Self, LabError> {
        let gpu = lab.gpu();
        let light = constants_buffer(gpu, "light constants", size_of::<MapLight>())?;
        let storage = |name, each: usize, count: u32| {
            Buffer::storage(gpu, name, each as u64 * u64::from(count), vk::BufferUsageFlags::empty())
        };
        let bounds = storage("sample bounds", 4 * 4, ANGLES * count)?;
        let fits = storage("fits", size_of::<Fit>(), layers)?;
        let slices = storage("slices", size_of::<Slices>(), 1)?;
        let position = u32::from(kind != Kind::Parallel);
        let measured = [&samples_of(screen, &light, &slices)[..], &[Binding::Storage(&bounds)]].concat();
        let constants = [count, position, 0, 0, 0, blend.to_bits(), 0, 0, 0, samples, BEND.to_bits()];
        let words = spirv!("methods/map_bounds.comp");
        Ok(Self {
            measure: Compute::new(gpu, "map_bounds", words, &measured, &constants, 0)?,
            choose: choose(gpu, &bounds, &fits)?,
            kind,
            side,
            border,
            count,
            light,
            bounds,
            fits,
            slices,
        })
    }

    /// What passes over the image read: `glsl/methods/sample.glsl`.
    pub(super) fn samples<'a>(&'a self, screen: &'a Screen) -> [Binding<'a>; 5] {
        samples_of(screen, &self.light, &self.slices)
    }

    /// Whether the light has a place, as a constant of shaders.
    pub(super) fn position(&self) -> u32 {
        u32::from(self.kind != Kind::Parallel)
    }

    fn write(&self, device: &ash::Device, cmd: vk::CommandBuffer, given: &Given, target: &Buffer) {
        // SAFETY: the command buffer is recording; the data is smaller than 64 KiB
        unsafe {
            device.cmd_update_buffer(cmd, self.light.raw, 0, bytemuck::bytes_of(&given.light));
            device.cmd_update_buffer(cmd, self.slices.raw, 0, bytemuck::bytes_of(&given.slices));
            device.cmd_fill_buffer(cmd, self.bounds.raw, 0, vk::WHOLE_SIZE, 0);
            if let Some(fits) = &given.fits {
                device.cmd_update_buffer(cmd, target.raw, 0, bytemuck::cast_slice(fits));
            }
        }
    }

    /// Device memory in bytes.
    pub(super) fn bytes(&self) -> u64 {
        self.light.size + self.bounds.size + self.fits.size + self.slices.size
    }

    /// Samples of the last frame that lay outside their layer.
    pub(super) fn outside(&self, lab: &Lab) -> Result<u64, LabError> {
        let slices: Slices = bytemuck::pod_read_unaligned(&lab.read_buffer(&self.slices)?[..size_of::<Slices>()]);
        Ok(slices.outside.into())
    }
}

fn choose(gpu: &Arc<Gpu>, bounds: &Buffer, target: &Buffer) -> Result<Compute, LabError> {
    let bindings = [bounds, target].map(Binding::Storage);
    Ok(Compute::new(gpu, "map_fit", spirv!("methods/map_fit.comp"), &bindings, &[], 8)?)
}

/// What has fits to samples.
pub(super) trait Fits {
    fn fitted(&self) -> &Fitted;
    /// Where the fits go.
    fn target(&self) -> &Buffer {
        &self.fitted().fits
    }
    /// Transfers before a frame.
    fn reset(&self, _cmd: vk::CommandBuffer) {}
}

/// The map of one light and its visibility.
pub(super) struct Map {
    shape: Shape,
    fitted: Fitted,
    tiles: Option<Tiles>,
    image: Image,
    /// The second surface, where the bias asks for it.
    second: Option<Image>,
    /// Where the bias asks for them.
    ids: Option<PolygonIds>,
    silhouettes: Option<SilhouetteMap>,
    visibility: Image,
    /// Without and with alpha test, for each layer.
    draws: Vec<[Graphics; 2]>,
    /// What draws the second surface, for each layer.
    peels: Vec<Graphics>,
    lookup: Compute,
    warped: Option<Warped>,
    gpu: Arc<Gpu>,
}

impl Map {
    pub(super) fn new(
        spec: &MethodSpec,
        lab: &Lab,
        screen: &Screen,
        light: &Light,
        shape: Shape,
    ) -> Result<Self, LabError> {
        let kind = map_light::kind(light);
        let position = u32::from(kind != Kind::Parallel);
        let gpu = lab.gpu();
        let Shape { side, layers, tiled, blend, comparison: Comparison { bias, cull, .. } } = shape;
        let largest = gpu.limits.max_image_dimension2_d.min(gpu.limits.max_framebuffer_width);
        if side > largest {
            return Err(LabError::Refused(format!("'{spec}': resolution is {side}, this device allows {largest}")));
        }
        let most = gpu.limits.max_image_array_layers.min(gpu.limits.max_framebuffer_layers);
        if layers > most {
            return Err(LabError::Refused(format!("'{spec}' has {layers} layers, this device allows {most}")));
        }
        use vk::{Format as F, ImageUsageFlags as I};
        // debug pictures copy what has silhouettes
        let usage = I::DEPTH_STENCIL_ATTACHMENT | I::SAMPLED | I::TRANSFER_SRC;
        let depths = ImageSpec { format: F::D32_SFLOAT, width: side, height: side, layers, usage };
        let image = Image::new(gpu, "map", &depths)?;
        let second = bias.peels().then(|| Image::new(gpu, "second map", &depths)).transpose()?;
        let edges = screen.edges.as_ref();
        let visibility = screen_image(lab, "visibility", F::R32_SFLOAT, I::STORAGE | I::TRANSFER_SRC)?;
        let count = shape.fitted();
        // silhouettes are looked up around the texel beside a sample's
        let border = shape.border() + u32::from(edges.is_some());
        let mut fitted = Fitted::new(lab, screen, kind, [side, layers, count, border], blend, 1)?;
        let tiles = tiled.then(|| Tiles::new(lab, &shape, &fitted.light, &fitted.fits)).transpose()?;
        if let Some(tiles) = &tiles {
            fitted.choose = choose(gpu, &fitted.bounds, &tiles.root)?;
        }
        let fits = &fitted.fits;
        let silhouettes =
            edges.map(|edges| SilhouetteMap::new(lab, edges, (&fitted.light, fits, &image), position)).transpose()?;
        let samples = fitted.samples(screen);
        // without tiles the shaders do not read them
        let pairs = Binding::Storage(tiles.as_ref().map_or(fits, |tiles| &tiles.pairs));
        let picked = Binding::Storage(tiles.as_ref().map_or(fits, |tiles| &tiles.picked));
        let draw = caster_bindings(lab, &fitted.light, fits, pairs);
        if bias == BiasKind::Ids && tiled {
            return Err(LabError::Refused(format!("'{spec}': bias=ids does not serve maps of tiles")));
        }
        let ids = (bias == BiasKind::Ids).then(|| PolygonIds::new(spec, lab, (&shape, kind), &draw)).transpose()?;
        // with a side left out every fragment is tested
        let depth_compare = vk::CompareOp::GREATER_OR_EQUAL;
        let state = |tested| GraphicsState {
            depth_compare,
            ..GraphicsState::casters(lab.scene_buffers().position_layout, tested)
        };
        // tiles take their layers from pairs
        let drawn = if tiled { 1 } else { layers };
        let pipeline = |layer: u32, masked: bool| {
            let constants = &[layer, position, cull as u32, tiled.into()];
            let name = if masked { "map_masked" } else { "map" };
            let shaders = if masked || cull != Cull::None {
                let (vertex, fragment) = (spirv!("methods/map_masked.vert"), spirv!("methods/map_masked.frag"));
                Shaders { vertex, tessellation: None, fragment: Some(fragment), constants }
            } else {
                Shaders { vertex: spirv!("methods/map.vert"), tessellation: None, fragment: None, constants }
            };
            let tested = shaders.fragment.is_some();
            Graphics::new(gpu, name, &shaders, if tested { &draw } else { &draw[..4] }, &state(tested))
        };
        let peel = |layer: u32| {
            let (vertex, fragment) = (spirv!("methods/map_masked.vert"), spirv!("methods/map_peel.frag"));
            let constants = &[layer, position, cull as u32, tiled.into()];
            let shaders = Shaders { vertex, tessellation: None, fragment: Some(fragment), constants };
            Graphics::new(gpu, "map_peel", &shaders, &[&draw[..], &[Binding::Sampled(&image)]].concat(), &state(true))
        };
        let peels = second.iter().flat_map(|_| 0..drawn).map(peel).collect::<Result<_, _>>()?;
        if tiled {
            // their contents stay from draw to draw
            let images: Vec<_> = [&image].into_iter().chain(&second).collect();
            lab.submit(|cmd| {
                for image in images {
                    sync::discard(&gpu.device, cmd, image, Access::Nothing, Access::LookupRead);
                }
            })?;
        }
        let own = [
            draw[1],
            Binding::Sampled(&image),
            Binding::StorageImage(&visibility),
            Binding::Sampled(second.as_ref().or(ids.as_ref().map(|ids| &ids.map)).unwrap_or(&image)),
            picked,
            owners_of(screen),
            Binding::Sampled(silhouettes.as_ref().map_or(&image, SilhouetteMap::points)),
        ];
        let constants = lookup_constants(&shape, position, silhouettes.is_some());
        let words = spirv!("methods/map_lookup.comp");
        Ok(Self {
            draws: (0..drawn)
                .map(|l| Ok([pipeline(l, false)?, pipeline(l, true)?]))
                .collect::<Result<_, LabError>>()?,
            lookup: Compute::new(gpu, "map_lookup", words, &[&samples[..], &own].concat(), &constants, 0)?,
            shape,
            fitted,
            tiles,
            image,
            second,
            ids,
            peels,
            silhouettes,
            visibility,
            warped: None,
            gpu: gpu.clone(),
        })
    }

    /// What passes over the image read: `glsl/methods/sample.glsl`.
    pub(super) fn samples<'a>(&'a self, screen: &'a Screen) -> [Binding<'a>; 5] {
        self.fitted.samples(screen)
    }

    /// What a map of tiles has beside; `None` for others.
    pub(super) fn tiles(&self) -> Option<&Tiles> {
        self.tiles.as_ref()
    }

    /// The tile of each pixel; without tiles what shaders do not read.
    pub(super) fn picked(&self) -> Binding<'_> {
        Binding::Storage(self.tiles.as_ref().map_or(self.fits(), |tiles| &tiles.picked))
    }

    /// What drawing reads where there are no tiles.
    pub(super) fn casters<'a>(&'a self, lab: &Lab) -> [Binding<'a>; 6] {
        caster_bindings(lab, self.light(), self.fits(), Binding::Storage(self.fits()))
    }

    /// What a lookup of depths, and of triangles where there are any, reads beside samples, and its constants.
    pub(super) fn lookup<'a>(&'a self, screen: &'a Screen) -> ([Binding<'a>; 7], [u32; 9]) {
        let image = Binding::Sampled(&self.image);
        let (fits, visibility) = (Binding::Storage(self.fits()), Binding::StorageImage(&self.visibility));
        let ids = Binding::Sampled(self.ids.as_ref().map_or(&self.image, |ids| &ids.map));
        let own = [fits, image, visibility, ids, self.picked(), owners_of(screen), image];
        (own, lookup_constants(&self.shape, self.fitted.position(), false))
    }

    /// Looks up by another pass from now on.
    pub(super) fn set_lookup(&mut self, lookup: Compute) {
        self.lookup = lookup;
    }

    /// The nearest triangle of each texel, where the map holds them.
    pub(super) fn ids(&self) -> Option<&PolygonIds> {
        self.ids.as_ref()
    }

    /// Draws and looks up the first surface through a warp from now on.
    pub(super) fn set_warped(&mut self, warped: Warped) {
        self.warped = Some(warped);
    }

    /// Depths of the last frame; nearest is greatest.
    pub(super) fn depths(&self, lab: &Lab) -> Result<Vec<f32>, LabError> {
        Ok(bytemuck::pod_collect_to_vec(&lab.read_image(&self.image, Access::ComputeRead, 4)?))
    }

    /// The fit of each layer.
    pub(super) fn fits(&self) -> &Buffer {
        &self.fitted.fits
    }

    pub(super) fn slices(&self) -> &Buffer {
        &self.fitted.slices
    }

    /// Stored depths of all layers; readable by lookups outside of [`Self::draw`].
    pub(super) fn image(&self) -> &Image {
        &self.image
    }

    /// The light's constants.
    pub(super) fn light(&self) -> &Buffer {
        &self.fitted.light
    }

    pub(super) fn kind(&self) -> Kind {
        self.fitted.kind
    }

    /// Visibility of the last frame.
    pub(super) fn visibility(&self, lab: &Lab) -> Result<Vec<f32>, LabError> {
        Ok(bytemuck::pod_collect_to_vec(&lab.read_image(&self.visibility, Access::TransferRead, 4)?))
    }

    /// What a map that holds silhouettes too has beside; `None` for others.
    pub(super) fn silhouettes(&self) -> Option<&SilhouetteMap> {
        self.silhouettes.as_ref()
    }

    /// The first layer with its silhouettes, where the map holds them.
    pub(super) fn debug_pictures(&self, lab: &Lab) -> Result<Vec<DebugPicture>, LabError> {
        self.silhouettes.iter().map(|silhouettes| silhouettes.picture(lab, &self.image)).collect()
    }

    /// Readable by transfers outside of [`Self::look_up`].
    pub(super) fn visibility_image(&self) -> &Image {
        &self.visibility
    }

    pub(super) fn shape(&self) -> &Shape {
        &self.shape
    }

    /// The fit of a layer to what it must hold.
    pub(super) fn fit(&self, points: &[DVec2]) -> Fit {
        least_area(points, self.shape.side.into(), self.fitted.border.into())
    }

    /// The first surface, then, where it is asked for, the second; both are left for lookups.
    pub(super) fn draw(&self, lab: &Lab, cmd: vk::CommandBuffer) {
        if let Some(tiles) = &self.tiles {
            tiles.cull(cmd);
        }
        if let Some(ids) = &self.ids {
            return ids.draw(lab, cmd, &self.image);
        }
        match &self.warped {
            Some(Warped { draws: [opaque, masked], fetches, .. }) => {
                self.draw_into(lab, cmd, &self.image, [[opaque, masked]].into_iter(), *fetches);
            }
            None => self.draw_fitted(lab, cmd, &self.image),
        }
        if let Some(second) = &self.second {
            self.draw_into(lab, cmd, second, self.peels.iter().map(|peel| [peel, peel]), false);
        }
    }

    /// The first surface where the fit has it, into an image of any size; it is left for lookups.
    pub(super) fn draw_fitted(&self, lab: &Lab, cmd: vk::CommandBuffer, image: &Image) {
        self.draw_into(lab, cmd, image, self.draws.iter().map(|[opaque, masked]| [opaque, masked]), false);
    }

    /// `pipelines`: for each layer, or for all tiles, what draws meshes that are not alpha tested, and those that are.
    /// `fetches`: see [`Warped`].
    fn draw_into<'a>(
        &self,
        lab: &Lab,
        cmd: vk::CommandBuffer,
        image: &Image,
        pipelines: impl Iterator<Item = [&'a Graphics; 2]>,
        fetches: bool,
    ) {
        use Access::{DepthAttachment, LookupRead};
        let device = &self.gpu.device;
        let scene = lab.scene_buffers();
        let load = if self.tiles.is_some() {
            sync::image(device, cmd, image, LookupRead, DepthAttachment);
            vk::AttachmentLoadOp::LOAD
        } else {
            sync::discard(device, cmd, image, LookupRead, DepthAttachment);
            vk::AttachmentLoadOp::CLEAR
        };
        let attachment = vk::RenderingAttachmentInfo::default()
            .image_view(image.view)
            .image_layout(vk::ImageLayout::DEPTH_ATTACHMENT_OPTIMAL)
            .load_op(load)
            .store_op(vk::AttachmentStoreOp::STORE)
            .clear_value(vk::ClearValue { depth_stencil: vk::ClearDepthStencilValue { depth: 0.0, stencil: 0 } });
        let area = vk::Rect2D { offset: vk::Offset2D::default(), extent: image.extent };
        let info =
            vk::RenderingInfo::default().render_area(area).layer_count(image.layers).depth_attachment(&attachment);
        // SAFETY: the command buffer is recording; buffers and images outlive the submission
        unsafe {
            device.cmd_begin_rendering(cmd, &info);
            set_area(device, cmd, area);
            device.cmd_bind_index_buffer(cmd, scene.indices, 0, vk::IndexType::UINT32);
            device.cmd_bind_vertex_buffers(cmd, 0, &scene.vertices(), &[0, 0]);
        }
        for pair in pipelines {
            match &self.tiles {
                Some(tiles) => tiles.draw(cmd, pair),
                None => self.draw_meshes(lab, cmd, pair, fetches),
            }
        }
        // SAFETY: rendering was begun above
        unsafe { device.cmd_end_rendering(cmd) };
        sync::image(device, cmd, image, DepthAttachment, LookupRead);
    }

    fn draw_meshes(&self, lab: &Lab, cmd: vk::CommandBuffer, pipelines: [&Graphics; 2], fetches: bool) {
        for (pipeline, alpha_tested) in pipelines.into_iter().zip([false, true]) {
            pipeline.bind(cmd);
            for d in casters(lab, alpha_tested) {
                // SAFETY: pipeline, set, index and vertex buffers are bound; inside rendering
                unsafe {
                    let device = &self.gpu.device;
                    let (count, first) = (d.index_count, d.first_index);
                    if fetches {
                        device.cmd_draw(cmd, 2 * count, d.instance_count, 2 * first, d.first_instance);
                    } else {
                        device.cmd_draw_indexed(cmd, count, d.instance_count, first, 0, d.first_instance);
                    }
                }
            }
        }
    }

    /// Visibility of every pixel from what was drawn last.
    pub(super) fn look_up(&self, cmd: vk::CommandBuffer, screen: &Screen) {
        use Access::{StorageImage, TransferRead};
        let device = &self.gpu.device;
        sync::discard(device, cmd, &self.visibility, TransferRead, StorageImage);
        let lookup = self.warped.as_ref().and_then(|warped| warped.lookup.as_ref()).unwrap_or(&self.lookup);
        lookup.dispatch(cmd, &(), [screen.size[0].div_ceil(8), screen.size[1].div_ceil(8), 1]);
        sync::image(device, cmd, &self.visibility, StorageImage, TransferRead);
    }
}

impl Fits for Map {
    fn fitted(&self) -> &Fitted {
        &self.fitted
    }

    fn target(&self) -> &Buffer {
        self.tiles.as_ref().map_or(self.fits(), |tiles| &tiles.root)
    }

    fn reset(&self, cmd: vk::CommandBuffer) {
        if let Some(silhouettes) = &self.silhouettes {
            silhouettes.reset(cmd);
        }
        if let Some(tiles) = &self.tiles {
            tiles.reset(cmd);
        }
    }
}

/// Draws of the casters that are, or are not, alpha tested.
pub(super) fn casters(lab: &Lab, alpha_tested: bool) -> impl Iterator<Item = &MeshDraw> {
    let meshes = lab.draws().iter().zip(&lab.scene().meshes);
    meshes.filter(move |(d, m)| m.casts && d.alpha_tested == alpha_tested).map(|(d, _)| d)
}

/// Fails where the view's lights are others in number or kind than the maps were made for.
pub(super) fn check_lights<T: Fits>(lab: &Lab, maps: &[T]) -> Result<(), LabError> {
    let lights = &lab.view().lights;
    if lights.len() != maps.len() {
        return Err(LabError::Refused(format!(
            "the view has {} lights, the method was made for {}",
            lights.len(),
            maps.len()
        )));
    }
    for (light, map) in lights.iter().zip(maps) {
        let (kind, made) = (map_light::kind(light), map.fitted().kind);
        if kind != made {
            return Err(LabError::Refused(format!("the light is {kind}, the method was made for {made}")));
        }
    }
    Ok(())
}

/// What the CPU gives for a frame of one light whose map is fitted to samples.
pub(super) fn given_samples(lab: &Lab, maps: &[Map; 1], comparison: &Comparison) -> Result<[Given; 1], LabError> {
    check_lights(lab, maps)?;
    let light = map_light::constants(&lab.view().lights[0], lab, comparison.bias_texels)?;
    Ok([Given { light, fits: None, slices: Slices::zeroed() }])
}

/// Records a frame of all lights; `steps` records what a method has of its own.
pub(super) fn record(
    (lab, camera): (&Lab, &Frame),
    (cmd, timer): (vk::CommandBuffer, &mut Timer),
    screen: &Screen,
    maps: &[Map],
    given: &[Given],
    steps: impl Fn(Step, vk::CommandBuffer, &mut Timer),
) {
    record_fits((lab, camera), (cmd, timer), screen, maps, given, steps);
    maps.iter().for_each(|map| map.draw(lab, cmd));
    timer.mark(cmd, "map");
    if screen.edges.is_some() {
        maps.iter().filter_map(|map| map.silhouettes.as_ref()).for_each(|silhouettes| silhouettes.record(cmd));
        timer.mark(cmd, "silhouettes");
    }
    maps.iter().for_each(|map| map.look_up(cmd, screen));
    timer.mark(cmd, "lookup");
}

/// The part of [`record`] before anything is drawn: what each pixel sees, and the fits.
pub(super) fn record_fits<T: Fits>(
    (lab, camera): (&Lab, &Frame),
    (cmd, timer): (vk::CommandBuffer, &mut Timer),
    screen: &Screen,
    maps: &[T],
    given: &[Given],
    steps: impl Fn(Step, vk::CommandBuffer, &mut Timer),
) {
    use Access::*;
    let device = &lab.gpu().device;
    let fitted = || maps.iter().zip(given).filter(|(_, given)| given.fits.is_none()).map(|(map, _)| map.fitted());
    sync::barrier(
        device,
        cmd,
        &[(ComputeRead, TransferWrite), (GraphicsRead, TransferWrite), (ComputeWrite, TransferWrite)],
    );
    // SAFETY: the command buffer is recording; the data is smaller than 64 KiB
    unsafe { device.cmd_update_buffer(cmd, screen.frame.raw, 0, bytemuck::bytes_of(camera)) };
    for (map, given) in maps.iter().zip(given) {
        map.fitted().write(device, cmd, given, map.target());
        map.reset(cmd);
    }
    steps(Step::Reset, cmd, timer);
    sync::barrier(
        device,
        cmd,
        &[(TransferWrite, ComputeRead), (TransferWrite, ComputeWrite), (TransferWrite, GraphicsRead)],
    );
    screen.receivers.record_discard(device, cmd);
    screen.gradient.record(cmd, screen.size);
    screen.receivers.record_written(device, cmd);
    timer.mark(cmd, "gradient");
    if let Some(owners) = screen.owners() {
        owners.record(lab, cmd, screen);
        timer.mark(cmd, "owners");
    }
    if fitted().next().is_some() {
        steps(Step::Slice, cmd, timer);
        fitted().for_each(|map| map.measure.dispatch(cmd, &(), screen.columns()));
        sync::barrier(device, cmd, &[(ComputeWrite, ComputeRead)]);
        fitted().for_each(|map| map.choose.dispatch(cmd, &[map.side, map.border].map(|v| v as f32), [map.count, 1, 1]));
        sync::barrier(device, cmd, &[(ComputeWrite, ComputeWrite)]);
        steps(Step::Fitted, cmd, timer);
        sync::barrier(device, cmd, &[(ComputeWrite, ComputeRead), (ComputeWrite, GraphicsRead)]);
        timer.mark(cmd, "fit");
    }
    steps(Step::Warp, cmd, timer);
}

/// Visibility of the last frame of all lights.
pub(super) fn masks(maps: &[Map]) -> Masks<'_> {
    Masks { images: maps.iter().map(|map| &map.visibility).collect(), bits: 32 }
}

/// Device memory by purpose, in bytes.
pub(super) fn memory(screen: &Screen, maps: &[Map]) -> Vec<(&'static str, u64)> {
    let sum = |bytes: fn(&Map) -> u64| maps.iter().map(bytes).sum::<u64>();
    let mut memory = vec![
        (
            "map",
            sum(|m| {
                let second = m.second.as_ref().or(m.ids.as_ref().map(|ids| &ids.map));
                m.image.bytes + second.map_or(0, |second| second.bytes)
            }),
        ),
        ("screen", screen.bytes() + sum(|m| m.visibility.bytes)),
        ("other", screen.frame.size + sum(|m| m.fitted.bytes() + m.tiles.as_ref().map_or(0, |tiles| tiles.bytes))),
    ];
    if let Some(edges) = &screen.edges {
        memory.push(("silhouettes", sum(|m| m.silhouettes.as_ref().map_or(0, SilhouetteMap::bytes))));
        memory.push(("edges", edges.bytes()));
    }
    memory
}

/// Statistics of the last frame of all lights.
pub(super) fn statistics(lab: &Lab, maps: &[Map]) -> Result<Statistics, LabError> {
    let (mut effective_resolution, mut outside, mut dropped, mut found) = (0.0f64, 0, None, None);
    for (map, light) in maps.iter().zip(&lab.view().lights) {
        let fits: Vec<Fit> = bytemuck::pod_collect_to_vec(&lab.read_buffer(map.fits())?);
        let texels = fits[..map.shape.layers as usize].iter().map(|f| f64::from(f.texel[0].min(f.texel[1])));
        let finest = texels.filter(|t| *t > 0.0).fold(f64::INFINITY, f64::min);
        effective_resolution = effective_resolution.max(map_light::extent(light, lab.scene_buffers()) / finest);
        outside += map.fitted.outside(lab)?;
        if let Some(tiles) = &map.tiles {
            dropped = Some(dropped.unwrap_or(0) + tiles.dropped(lab)?);
        }
        if let Some(silhouettes) = &map.silhouettes {
            found = Some(found.unwrap_or(0) + silhouettes.found(lab)?.len() as u64);
        }
    }
    let mut counters = vec![("outside", outside)];
    counters.extend(dropped.map(|count| ("dropped", count)));
    counters.extend(found.map(|count| ("silhouettes", count)));
    Ok(Statistics { effective_resolution, counters, ..Statistics::default() })
}
