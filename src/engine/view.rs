//! One view of a frame: its constants, images and the passes that run for each pixel.

use super::buffers::Buffers;
use super::bvh::Bvh;
use super::exact::{self, Exact};
use super::gradient::Gradient;
use super::lookup::Lookup;
use super::request::Request;
use super::sort::Sort;
use crate::gpu::{Binding, Buffer, Gpu, Image, ImageSpec};
use crate::host::{Receivers, SceneBuffers};
use crate::{Config, Error};
use ash::vk;
use std::sync::Arc;

/// Rays of each sample of a small image; others have as many as pixels, or a quarter of their samples if those are more, and
/// none more than a storage buffer holds.
const LEAST_RAYS: u32 = 16384;

/// What the passes of a view read and write.
pub(crate) struct ViewBuffers {
    pub(crate) receiver: Image,
    pub(crate) tile_lights: Buffer,
    pub(crate) mask: Image,
}

impl ViewBuffers {
    pub(crate) fn new(gpu: &Arc<Gpu>, config: &Config, [width, height]: [u32; 2]) -> Result<Self, Error> {
        use vk::ImageUsageFlags as I;
        let tiles = u64::from(width.div_ceil(8)) * u64::from(height.div_ceil(8));
        let words = u64::from(config.lights.div_ceil(32));
        let screen =
            |name, format, layers, usage| Image::new(gpu, name, &ImageSpec { format, width, height, layers, usage });
        Ok(Self {
            receiver: screen("receiver planes", vk::Format::R32G32B32A32_UINT, 0, I::STORAGE | I::SAMPLED)?,
            tile_lights: Buffer::storage(gpu, "lights of tiles", 4 * tiles * words, vk::BufferUsageFlags::empty())?,
            mask: screen(
                "mask",
                vk::Format::R32_UINT,
                config.mask_layers(),
                I::STORAGE | I::SAMPLED | I::TRANSFER_SRC,
            )?,
        })
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.receiver.bytes + self.tile_lights.size + self.mask.bytes
    }
}

/// A view and its passes.
pub(crate) struct View {
    pub(crate) size: [u32; 2],
    pub(crate) buffers: ViewBuffers,
    pub(crate) gradient: Gradient,
    pub(crate) request: Request,
    pub(crate) lookup: Lookup,
    pub(crate) exact: Option<Exact>,
}

impl View {
    /// View `number`, which sees `receivers`.
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        config: &Config,
        scene: &SceneBuffers,
        b: &Buffers,
        sort: Option<&Sort>,
        (number, receivers): (usize, &Receivers),
        bvh: Option<&Bvh>,
    ) -> Result<Self, Error> {
        let size = receivers.size;
        let buffers = ViewBuffers::new(gpu, config, size)?;
        let frame = b.frame(number);
        let pixels = size[0].saturating_mul(size[1]);
        let rays = pixels.saturating_mul(config.samples.div_ceil(4)).max(LEAST_RAYS * config.samples);
        let rays = rays.min(gpu.limits.max_storage_buffer_range / exact::RAY_BYTES);
        let exact = || Exact::new(gpu, config, scene, bvh, rays, frame, Some(&buffers.mask));
        let exact = config.exact.then(exact).transpose()?;
        Ok(Self {
            size,
            gradient: Gradient::new(gpu, frame, receivers, Binding::StorageImage(&buffers.receiver))?,
            request: Request::new(gpu, config, b, (number, &buffers), sort, receivers)?,
            lookup: Lookup::new(gpu, config, b, (number, &buffers), receivers, exact.as_ref())?,
            exact,
            buffers,
        })
    }
}
