//! The adaptive shadow map: resolution-matched pages for the visible samples of a frame, found, drawn and looked up on
//! the GPU.

pub(crate) mod allocate;
pub(crate) mod buffers;
pub(crate) mod bvh;
pub(crate) mod cache;
pub(crate) mod compact;
pub(crate) mod constants;
pub(crate) mod cull;
pub(crate) mod depth_prepass;
pub(crate) mod exact;
mod frame;
#[cfg(feature = "lab")]
mod frozen;
pub(crate) mod gradient;
pub(crate) mod lights;
pub(crate) mod lookup;

pub(crate) mod query;
pub(crate) mod request;
pub(crate) mod sort;
mod steer;
pub(crate) mod tiles;
pub(crate) mod view;

pub use depth_prepass::{DepthPrepass, MeshDraw};
pub use lights::LightId;

use crate::config::RequestRoute;
use crate::gpu::structs::{Counters, frame_flags};
use crate::gpu::{Gpu, HostDevice, Timer};
use crate::host::{FrameInput, Receivers, SceneBuffers};
use crate::{Config, Error, Light};
use ash::vk;
use buffers::Buffers;
use bytemuck::Zeroable;
use constants::History;
use frame::FrameData;
use lights::Lights;
use std::sync::Arc;
use view::View;

/// Layers that `cache_assign` has room for.
const MAX_LAYERS: u32 = 2048;
/// Most views of a frame.
const MAX_VIEWS: usize = 16;

/// The engine: the lights and the views of one scene.
pub struct Engine {
    pub(crate) config: Config,
    pub(crate) buffers: Buffers,
    pub(crate) views: Vec<View>,
    lights: Lights,
    pub(crate) bvh: Option<bvh::Bvh>,
    sort: Option<sort::Sort>,
    compact: Option<compact::Compact>,
    cache: cache::Cache,
    allocate: allocate::Allocate,
    cull: cull::Cull,
    tiles: tiles::Tiles,
    steering: steer::Steering,
    history: History,
    data: FrameData,
    /// Frames so far.
    recorded: u64,
    scene: SceneBuffers,
    gpu: Arc<Gpu>,
}

/// A descriptor set for shaders of the host.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ShaderSet {
    /// For the host's pipeline layouts.
    pub layout: vk::DescriptorSetLayout,
    /// Bound at the number that the shader calls `UMBRAGE_SET` or `UMBRAGE_CASTER_SET`.
    pub set: vk::DescriptorSet,
}

/// A recorded frame of an engine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FrameId(u64);

#[cfg(feature = "capi")]
impl FrameId {
    /// Frames before it and itself.
    pub(crate) fn number(self) -> u64 {
        self.0
    }

    /// What [`FrameId::number`] gave.
    pub(crate) fn from_number(number: u64) -> Self {
        Self(number)
    }
}

impl Engine {
    /// Makes everything the engine needs; nothing is allocated afterwards. `views`: what each view of a frame sees;
    /// they share pages.
    ///
    /// # Errors
    /// [`Error::Limit`] for a configuration out of range, [`Error::Unsupported`] for a device that lacks something,
    /// [`Error::OutOfMemory`] and [`Error::Vulkan`] as the device reports them.
    ///
    /// # Safety
    /// All handles must be valid, made with the features of [`crate::gpu::requirements`], and outlive the engine.
    pub unsafe fn new(
        host: &HostDevice,
        config: &Config,
        scene: &SceneBuffers,
        views: &[Receivers<'_>],
    ) -> Result<Self, Error> {
        // SAFETY: the caller vouches for the handles
        let gpu = unsafe { Gpu::new(host)? };
        Self::on(&gpu, config, scene, views)
    }

    pub(crate) fn on(
        gpu: &Arc<Gpu>,
        config: &Config,
        scene: &SceneBuffers,
        views: &[Receivers<'_>],
    ) -> Result<Self, Error> {
        config.check(gpu.limits.max_image_array_layers.min(gpu.limits.max_framebuffer_layers).min(MAX_LAYERS))?;
        scene.check()?;
        if !(1..=MAX_VIEWS).contains(&views.len()) {
            return Err(Error::Limit {
                field: "views",
                given: views.len().to_string(),
                limit: format!("1 to {MAX_VIEWS}"),
            });
        }
        let (casters, least) = (scene.caster_count, Config::least_pairs(scene.caster_count));
        if config.pair_capacity < least {
            return Err(Error::Limit {
                field: "pair_capacity",
                given: config.pair_capacity.to_string(),
                limit: format!("at least {least} for the scene's {casters} clusters"),
            });
        }
        if config.exact && scene.host_draws.is_some() {
            let limit = "false with casters that the host draws, which rays do not see".into();
            return Err(Error::Limit { field: "exact", given: "true".into(), limit });
        }
        let most = gpu.limits.max_draw_indirect_count;
        if config.pair_capacity > most {
            return Err(Error::Limit {
                field: "pair_capacity",
                given: config.pair_capacity.to_string(),
                limit: format!("at most {most}, the draws of one command on this device"),
            });
        }
        // what does not depend on the size that views have now
        let pixels = views.len() as u64 * u64::from(config.size[0]) * u64::from(config.size[1]);
        let b = Buffers::new(gpu, config, scene, views.len() as u32)?;
        let sort = match config.route {
            RequestRoute::Flags => None,
            RequestRoute::Sort => {
                // room for each key that a workgroup's 64 pixels may ask for
                let [x, y] = config.size.map(|side| u64::from(side.div_ceil(8)));
                let capacity = 64 * views.len() as u64 * x * y * (1 + u64::from(config.level_blend));
                let capacity = u32::try_from(capacity).map_err(|_| Error::Limit {
                    field: "route",
                    given: format!("sort of {capacity} requests"),
                    limit: "less than 2^32 of all views".into(),
                })?;
                Some(sort::Sort::new(gpu, &b.counters, &b.arguments, capacity)?)
            }
        };
        let compact = sort.as_ref().map(|sort| compact::Compact::new(gpu, &b, sort)).transpose()?;
        let tree = config.exact && !query::chosen(gpu, config, scene);
        let bvh = tree.then(|| bvh::Bvh::new(gpu, scene)).transpose()?;
        Ok(Self {
            views: View::all(gpu, config, scene, &b, sort.as_ref(), bvh.as_ref(), views)?,
            lights: Lights::new(config.lights),
            cache: cache::Cache::new(gpu, config, &b, scene, bvh.as_ref().map(|bvh| &bvh.changes))?,
            allocate: allocate::Allocate::new(gpu, config, pixels, &b, compact.as_ref())?,
            cull: cull::Cull::new(gpu, config, &b, scene)?,
            tiles: tiles::Tiles::new(gpu, config, &b, scene)?,
            bvh,
            sort,
            compact,
            buffers: b,
            steering: steer::Steering::new(config),
            history: History::default(),
            data: FrameData::with_room(views.len(), config.lights as usize),
            recorded: 0,
            config: config.clone(),
            scene: *scene,
            gpu: gpu.clone(),
        })
    }

    /// Adds a light.
    ///
    /// # Errors
    /// [`Error::Limit`] for a light with extent or out of range, and beyond [`Config::lights`].
    pub fn add_light(&mut self, light: &Light) -> Result<LightId, Error> {
        self.lights.add(light)
    }

    /// Changes a light. Pages of a directional light outlive small turns ([`Config::drift_texels`]); those of others are
    /// drawn anew after any change.
    ///
    /// # Errors
    /// As [`Engine::add_light`]; [`Error::Limit`] for the id of a light that was removed.
    pub fn set_light(&mut self, id: LightId, light: &Light) -> Result<(), Error> {
        self.lights.set(id, light)
    }

    /// Removes a light; its slot may be given to another.
    ///
    /// # Errors
    /// [`Error::Limit`] for the id of a light that was removed.
    pub fn remove_light(&mut self, id: LightId) -> Result<(), Error> {
        self.lights.remove(id)
    }

    /// Forgets all pages and casters: the next frame is a first one. For hosts that recorded a frame and never submitted
    /// it, or changed their buffers without telling.
    pub fn forget(&mut self) {
        self.history = History::default();
        self.lights.forget();
    }

    /// Records one frame into `cmd`: requests, allocation, tiles, lookup; one input for each view. Allocates nothing. The
    /// commands take the receivers' images from their last use and the masks to theirs, by barriers as
    /// [`Receivers`] says.
    ///
    /// # Errors
    /// [`Error::Limit`] for another number of inputs than there are views, for images that a view does not have, for
    /// cameras that [`FrameInput`] does not allow, and where [`Engine::record_with`] is needed; then nothing was recorded.
    ///
    /// # Safety
    /// `cmd` must be recording outside of rendering, on a queue with graphics and compute; every recorded frame of an engine
    /// must run, once, in the order of recording and on one queue (else call [`Engine::forget`]). Any number of frames may
    /// be in flight. What the host changes in its buffers is ordered before the commands and after those of the frame before: the
    /// engine reads them in compute and vertex shaders and as vertices and indices, and writes `indices` and
    /// `host_draws` in compute shaders.
    ///
    /// lavapipe (22.3, 25.0) holds indirect draws that the host records after these commands in the same command buffer to the
    /// engine's count of draws: draw directly there, or in another command buffer.
    pub unsafe fn record(&mut self, cmd: vk::CommandBuffer, inputs: &[FrameInput]) -> Result<FrameId, Error> {
        self.record_timed(cmd, inputs, None, None)
    }

    /// As [`Engine::record`], for scenes with casters that the host draws ([`SceneBuffers::host_draws`]): `draw` is called once,
    /// while the frame is recorded, where their draws belong. It binds pipelines of the host's own with
    /// [`Engine::casters`] (asked before) in their layout and `glsl/host/umbrage_caster.glsl` in their vertex or tessellation
    /// evaluation shader, and records `vkCmdDrawIndexedIndirect` from [`SceneBuffers::host_draws`], of one instance or of several
    /// that follow each other: instance `i` at byte `20 * i`. Other sets, push constants, vertex and index buffers are the
    /// host's own business.
    ///
    /// The commands lie inside of dynamic rendering into a D32_SFLOAT depth attachment of many layers, without colour,
    /// of one sample; viewport and scissor are set, for pipelines that have them as dynamic state. Depth is tested
    /// and written by `GREATER_OR_EQUAL`, without bias; both sides cast. A fragment shader may discard. A caster whose shape changes
    /// needs another revision or [`crate::CastPolicy::Always`], as pages are kept: let wind or level of detail not depend
    /// on the camera. Each draw costs all triangles of the mesh once for each page that its bounds touch.
    ///
    /// # Errors
    /// As [`Engine::record`].
    ///
    /// # Safety
    /// As [`Engine::record`]; `draw` leaves the command buffer inside of the same rendering, and what it binds stays valid.
    pub unsafe fn record_with(
        &mut self,
        cmd: vk::CommandBuffer,
        inputs: &[FrameInput],
        draw: &mut dyn FnMut(vk::CommandBuffer),
    ) -> Result<FrameId, Error> {
        self.record_timed(cmd, inputs, Some(draw), None)
    }

    /// Makes the views anew, as many as there were, for other sizes or other images; pages and lights stay. After an error
    /// the engine is as it was.
    ///
    /// # Errors
    /// As [`Engine::new`]; [`Error::Limit`] for another number of views.
    ///
    /// # Safety
    /// As [`Engine::new`]; no recorded frame may still be running or waiting to run.
    pub unsafe fn resize(&mut self, views: &[Receivers<'_>]) -> Result<(), Error> {
        self.check_views(views.len())?;
        let (bvh, sort) = (self.bvh.as_ref(), self.sort.as_ref());
        self.views = View::all(&self.gpu, &self.config, &self.scene, &self.buffers, sort, bvh, views)?;
        Ok(())
    }

    fn check_views(&self, given: usize) -> Result<(), Error> {
        let views = self.views.len();
        if given == views {
            return Ok(());
        }
        let limit = format!("{views}, as many as the engine was made with");
        Err(Error::Limit { field: "views", given: given.to_string(), limit })
    }

    pub(crate) fn record_timed(
        &mut self,
        cmd: vk::CommandBuffer,
        inputs: &[FrameInput],
        draw: Option<&mut dyn FnMut(vk::CommandBuffer)>,
        timer: Option<&mut Timer>,
    ) -> Result<FrameId, Error> {
        self.check_views(inputs.len())?;
        if self.scene.host_draws.is_some() && draw.is_none() {
            let given = "recorded without a callback that draws them".into();
            return Err(Error::Limit { field: "host_draws", given, limit: "record_with, or no host_draws".into() });
        }
        inputs.iter().zip(&self.views).try_for_each(|(input, view)| view.check_images(input.images))?;
        let first = self.history.frame == 0;
        let mut forget = 0;
        if first || !self.config.cache {
            forget |= frame_flags::FORGET_PAGES;
        }
        if first {
            forget |= frame_flags::FORGET_CASTERS;
        }
        let mut next = History {
            flags: forget,
            frame: self.history.frame.wrapping_add(1).max(1),
            bias: self.steering.bias(),
            page_cost: self.steering.page_cost(),
        };
        let used = self.lights.used();
        let mut data = std::mem::take(&mut self.data);
        let filled = self.fill(&mut data, inputs, &next);
        if filled.is_ok() {
            if self.lights.turned(&mut data.lights[..used as usize]) {
                next.flags |= frame_flags::LIGHT_MOVED;
            }
            self.finish(&mut data, next.flags);
            self.history = next;
            self.recorded += 1;
            self.record_timeline(cmd, &data, draw, timer);
        }
        self.data = data;
        filled.map(|()| FrameId(self.recorded))
    }

    /// What the constants of the views take from all lights.
    fn finish(&self, data: &mut FrameData, flags: u32) {
        let (used, local) = (self.lights.used(), u32::from(self.lights.any_local()));
        let lookup = u32::from(self.config.level_blend) | u32::from(self.config.filter.ranged()) << 1;
        for (view, constants) in (0..).zip(&mut data.constants) {
            constants.cache[0] = flags;
            constants.size[3] = view * used;
            constants.lights = [used, local, self.config.gutter, lookup];
            constants.sun = data.lights.get((view * used) as usize).copied().unwrap_or(Zeroable::zeroed());
        }
    }

    /// What depends on the inputs alone.
    fn fill(&self, data: &mut FrameData, inputs: &[FrameInput], next: &History) -> Result<(), Error> {
        data.constants.clear();
        data.images.clear();
        data.lights.clear();
        for (input, view) in inputs.iter().zip(&self.views) {
            let mut constants = constants::constants(&self.config, view.size, &self.scene, input, next)?;
            constants.eye_low[3] = view.gradients[input.images].0.depth.rounding();
            data.constants.push(constants);
            data.images.push(input.images);
            self.lights.records(&self.config, &self.scene, input, next, &mut data.lights)?;
        }
        Ok(())
    }

    /// Tells how long the GPU took for a finished frame, in milliseconds, from which the engine steers its work towards
    /// [`Config::target_ms`]; without a target, and for a frame that [`Engine::counters`] does not know, nothing happens.
    /// `tiles_ms`: the part of it spent in culling and tiles, 0 where that is not known. Call it once a frame, in order.
    pub fn steer(&mut self, frame: FrameId, gpu_ms: f64, tiles_ms: f64) {
        if let Some(counters) = self.counters(frame) {
            self.steering.measured(gpu_ms, tiles_ms, &counters);
        }
    }

    /// Counters of a frame that the caller has waited for; `None` when [`Config::frames_in_flight`] later ones were recorded.
    pub fn counters(&self, frame: FrameId) -> Option<Counters> {
        let FrameId(number) = frame;
        let kept = number > 0 && number <= self.recorded && self.recorded - number < self.frames_in_flight();
        let from = self.readback_offset(number) as usize;
        kept.then(|| bytemuck::pod_read_unaligned(&self.buffers.readback.bytes()[from..][..size_of::<Counters>()]))
    }

    /// Counters of the last recorded frame, all zero before the first.
    #[cfg(feature = "lab")]
    pub(crate) fn last_counters(&self) -> Counters {
        self.counters(FrameId(self.recorded)).unwrap_or_else(Counters::zeroed)
    }

    fn frames_in_flight(&self) -> u64 {
        u64::from(self.config.frames_in_flight)
    }

    /// Where the counters of a frame are copied to.
    fn readback_offset(&self, number: u64) -> u64 {
        number % self.frames_in_flight() * size_of::<Counters>() as u64
    }

    /// Device memory by purpose, in bytes.
    pub fn memory(&self) -> Vec<(&'static str, u64)> {
        let mut memory = self.buffers.memory();
        memory.push(("screen", self.views.iter().map(|view| view.buffers.bytes()).sum()));
        let sort = self.sort.as_ref().map_or(0, sort::Sort::bytes);
        let rays: u64 = self.views.iter().filter_map(|view| view.exact.as_ref()).map(exact::Exact::bytes).sum();
        memory.push(("exact", rays + self.bvh.as_ref().map_or(0, bvh::Bvh::bytes)));
        memory.push(("sort", sort + self.compact.as_ref().map_or(0, compact::Compact::bytes)));
        memory
    }

    /// What shaders of the host bind to look shadows up themselves in a view, after the commands of its frame and before
    /// those of the next: `glsl/host/umbrage.glsl`. Vertex, fragment and compute shaders may. [`Engine::resize`] makes others: layouts of the same
    /// kind, so that pipelines stay valid, but the handles are gone. On edges lookups and the mask differ where rays decided the
    /// mask, and where a shader's derivatives are not those of the surface.
    ///
    /// # Panics
    /// When there is no such view.
    pub fn lookup(&self, view: usize) -> ShaderSet {
        let (layout, set) = self.views[view].host_set.handles();
        ShaderSet { layout, set }
    }

    /// What pipelines of the host bind to draw casters in [`Engine::record_with`]: `glsl/host/umbrage_caster.glsl`; `None`
    /// without [`SceneBuffers::host_draws`]. It stays as long as the engine.
    pub fn casters(&self) -> Option<ShaderSet> {
        self.tiles.host_set().map(|(layout, set)| ShaderSet { layout, set })
    }

    /// The mask of a view, of its size, and a view of all its layers (`usampler2DArray`, or `uimage2DArray`): R32_UINT images of usage
    /// `SAMPLED`, `STORAGE` and `TRANSFER_SRC` with [`Config::mask_bits`] for each light, in the order of slots from
    /// the lowest bits of the first layer. 1 lit, 0 shadowed or not reached by the light, 1 where there is no surface, shares with
    /// a filter or several samples a pixel. With
    /// 32 bits the words are floats (`uintBitsToFloat`), and layer `i` is the light of slot `i`; with fewer, slot `i` has the bits from
    /// `i * mask_bits % 32` on in layer `i * mask_bits / 32`. Slots without a light mean nothing. [`Engine::resize`] makes others.
    ///
    /// # Panics
    /// When there is no such view.
    pub fn mask(&self, view: usize) -> (vk::Image, vk::ImageView) {
        let mask = &self.views[view].buffers.mask;
        (mask.raw, mask.view)
    }
}
