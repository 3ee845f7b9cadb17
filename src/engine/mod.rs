//! The adaptive shadow map: resolution-matched pages for the visible samples of a frame, found, drawn and looked up on
//! the GPU.

pub(crate) mod allocate;
pub(crate) mod buffers;
pub(crate) mod cache;
pub(crate) mod compact;
pub(crate) mod constants;
pub(crate) mod cull;
pub(crate) mod depth_prepass;
mod frame;
pub(crate) mod gradient;
pub(crate) mod lookup;
pub(crate) mod request;
pub(crate) mod sort;
mod steer;
pub(crate) mod tiles;

pub use depth_prepass::{DepthPrepass, MeshDraw};

use crate::config::RequestRoute;
use crate::gpu::structs::{Counters, frame_flags};
use crate::gpu::{Gpu, HostDevice, Timer};
use crate::host::{FrameInput, Receivers, SceneBuffers};
use crate::{Config, Error};
use ash::vk;
use buffers::Buffers;
use constants::History;
use std::sync::Arc;

/// Layers that `cache_assign` has room for.
const MAX_LAYERS: u32 = 2048;

/// The engine: one light, one view, one scene.
pub struct Engine {
    pub(crate) config: Config,
    pub(crate) buffers: Buffers,
    gradient: gradient::Gradient,
    request: request::Request,
    sort: Option<sort::Sort>,
    compact: Option<compact::Compact>,
    page_sort: sort::Sort,
    cache: cache::Cache,
    allocate: allocate::Allocate,
    cull: cull::Cull,
    tiles: tiles::Tiles,
    lookup: lookup::Lookup,
    steering: steer::Steering,
    history: History,
    light: Option<[[f32; 4]; 2]>,
    scene: SceneBuffers,
    gpu: Arc<Gpu>,
}

impl Engine {
    /// Makes everything the engine needs; nothing is allocated afterwards.
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
        receivers: &Receivers,
    ) -> Result<Self, Error> {
        // SAFETY: the caller vouches for the handles
        let gpu = unsafe { Gpu::new(host)? };
        Self::on(&gpu, config, scene, receivers)
    }

    pub(crate) fn on(
        gpu: &Arc<Gpu>,
        config: &Config,
        scene: &SceneBuffers,
        receivers: &Receivers,
    ) -> Result<Self, Error> {
        config.check(gpu.limits.max_image_array_layers.min(gpu.limits.max_framebuffer_layers).min(MAX_LAYERS))?;
        let (casters, least) = (scene.caster_count, Config::least_pairs(scene.caster_count));
        if config.pair_capacity < least {
            return Err(Error::Limit {
                field: "pair_capacity",
                given: config.pair_capacity.to_string(),
                limit: format!("at least {least} for the scene's {casters} clusters"),
            });
        }
        let most = gpu.limits.max_draw_indirect_count;
        if config.pair_capacity > most {
            return Err(Error::Limit {
                field: "pair_capacity",
                given: config.pair_capacity.to_string(),
                limit: format!("at most {most}, the draws of one command on this device"),
            });
        }
        let b = Buffers::new(gpu, config, scene)?;
        let page_sort = sort::Sort::new(gpu, &b.counters, &b.arguments, sort::Sorted::Pages, config.page_capacity())?;
        let sort = match config.route {
            RequestRoute::Flags => None,
            RequestRoute::Sort => {
                // a workgroup appends at most one key for each of its 64 pixels
                let capacity = 64 * config.size[0].div_ceil(8) * config.size[1].div_ceil(8);
                Some(sort::Sort::new(gpu, &b.counters, &b.arguments, sort::Sorted::Requests, capacity)?)
            }
        };
        let compact = sort.as_ref().map(|sort| compact::Compact::new(gpu, &b, sort)).transpose()?;
        // the flags route appends nothing; its pass still needs every binding filled
        let request = request::Request::new(gpu, config, &b, sort.as_ref().unwrap_or(&page_sort), receivers)?;
        Ok(Self {
            gradient: gradient::Gradient::for_engine(gpu, &b, receivers)?,
            request,
            cache: cache::Cache::new(gpu, config, &b, scene)?,
            allocate: allocate::Allocate::new(gpu, config, &b, compact.as_ref(), &page_sort)?,
            cull: cull::Cull::new(gpu, config, &b, scene)?,
            tiles: tiles::Tiles::new(gpu, config, &b, scene)?,
            lookup: lookup::Lookup::new(gpu, config, &b, receivers)?,
            sort,
            compact,
            page_sort,
            buffers: b,
            steering: steer::Steering::new(config),
            history: History::default(),
            light: None,
            config: config.clone(),
            scene: *scene,
            gpu: gpu.clone(),
        })
    }

    /// Forgets all pages and casters: the next frame is a first one. For hosts that recorded a frame and never submitted
    /// it, or changed their buffers without telling.
    pub fn forget(&mut self) {
        self.history = History::default();
        self.light = None;
    }

    /// Records one frame into `cmd`: requests, allocation, tiles, lookup. The mask is left in `TRANSFER_SRC_OPTIMAL`.
    ///
    /// # Errors
    /// [`Error::Limit`] when the light's direction is zero or not finite.
    ///
    /// # Safety
    /// `cmd` must be recording outside of rendering; the receivers' images must be readable by compute shaders; every
    /// recorded frame of an engine must run, once, in the order of recording (else call [`Engine::forget`]). A host that
    /// samples the mask orders that before the next frame's commands.
    pub unsafe fn record(&mut self, cmd: vk::CommandBuffer, input: &FrameInput) -> Result<(), Error> {
        self.record_timed(cmd, input, None)
    }

    pub(crate) fn record_timed(
        &mut self,
        cmd: vk::CommandBuffer,
        input: &FrameInput,
        timer: Option<&mut Timer>,
    ) -> Result<(), Error> {
        let first = self.history.frame == 0;
        let mut forget = 0;
        if first || !self.config.cache {
            forget |= frame_flags::FORGET_PAGES;
        }
        if first {
            forget |= frame_flags::FORGET_CASTERS;
        }
        let next = History {
            flags: forget,
            frame: self.history.frame.wrapping_add(1).max(1),
            bias: self.steering.bias(),
            page_cost: self.steering.page_cost(),
        };
        let mut constants = constants::constants(&self.config, &self.scene, input, &next)?;
        let axis = |v: [f32; 4]| [v[0], v[1], v[2], 0.0];
        let light = [axis(constants.light_x), axis(constants.light_z)];
        if self.light != Some(light) {
            constants.cache[0] |= frame_flags::LIGHT_MOVED;
        }
        (self.history, self.light) = (next, Some(light));
        self.record_timeline(cmd, &constants, timer);
        Ok(())
    }

    /// Tells how long the GPU took for a frame, in milliseconds, from which the engine steers its work towards
    /// [`Config::target_ms`]; without a target nothing happens. `tiles_ms`: the part of it spent in culling and tiles, 0
    /// where that is not known. Call it once a frame, in order, with times of finished frames only.
    pub fn steer(&mut self, gpu_ms: f64, tiles_ms: f64) {
        let counters = self.counters();
        self.steering.measured(gpu_ms, tiles_ms, &counters);
    }

    /// Counters of the last frame that the caller has waited for; with several frames in flight, of a later one perhaps.
    pub fn counters(&self) -> Counters {
        bytemuck::pod_read_unaligned(&self.buffers.readback.bytes()[..size_of::<Counters>()])
    }

    /// Device memory by purpose, in bytes.
    pub fn memory(&self) -> Vec<(&'static str, u64)> {
        let mut memory = self.buffers.memory();
        let sorts = self.page_sort.bytes() + self.sort.as_ref().map_or(0, sort::Sort::bytes);
        memory.push(("sort", sorts + self.compact.as_ref().map_or(0, compact::Compact::bytes)));
        memory
    }

    /// The mask: R32_SFLOAT, 1 lit, 0 shadowed, 1 where there is no surface.
    pub fn visibility(&self) -> (vk::Image, vk::ImageView) {
        (self.buffers.visibility.raw, self.buffers.visibility.view)
    }
}
