//! One view of a frame: its constants, images and the passes that run for each pixel.

use super::buffers::Buffers;
use super::bvh::Bvh;
use super::exact::{self, Exact};
use super::gradient::{self, Gradient};
use super::lookup::Lookup;
use super::request::Request;
use super::sort::Sort;
use crate::gpu::sync;
use crate::gpu::{Buffer, Gpu, HostSet, Image, ImageSpec};
use crate::host::{ImageUse, ReceiverImages, Receivers, SceneBuffers};
use crate::{Config, Error};
use ash::vk;
use std::sync::Arc;

/// Rays of each sample of a small image; others have as many as pixels, or a quarter of their samples if those are more, and
/// none more than a storage buffer holds.
const LEAST_RAYS: u32 = 16384;

/// What the passes of a view read and write.
pub(crate) struct ViewBuffers {
    pub(crate) receivers: gradient::Receivers,
    pub(crate) tile_lights: Buffer,
    pub(crate) mask: Image,
}

impl ViewBuffers {
    pub(crate) fn new(gpu: &Arc<Gpu>, config: &Config, [width, height]: [u32; 2]) -> Result<Self, Error> {
        use vk::ImageUsageFlags as I;
        let tiles = u64::from(width.div_ceil(8)) * u64::from(height.div_ceil(8));
        let words = u64::from(config.lights.div_ceil(32));
        Ok(Self {
            receivers: gradient::Receivers::new(gpu, [width, height])?,
            tile_lights: Buffer::storage(gpu, "lights of tiles", 4 * tiles * words, vk::BufferUsageFlags::empty())?,
            mask: Image::new(
                gpu,
                "mask",
                &ImageSpec {
                    format: vk::Format::R32_UINT,
                    width,
                    height,
                    layers: config.mask_layers(),
                    usage: I::STORAGE | I::SAMPLED | I::TRANSFER_SRC,
                },
            )?,
        })
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.receivers.bytes() + self.tile_lights.size + self.mask.bytes
    }
}

/// A view and its passes.
pub(crate) struct View {
    pub(crate) size: [u32; 2],
    pub(crate) mask_use: ImageUse,
    pub(crate) buffers: ViewBuffers,
    /// One for each of the images that frames may come with.
    pub(crate) gradients: Vec<(ReceiverImages, Gradient)>,
    pub(crate) request: Request,
    pub(crate) lookup: Lookup,
    pub(crate) host_set: HostSet,
    pub(crate) exact: Option<Exact>,
}

impl View {
    /// The views of an engine.
    pub(crate) fn all(
        gpu: &Arc<Gpu>,
        config: &Config,
        scene: &SceneBuffers,
        b: &Buffers,
        sort: Option<&Sort>,
        bvh: Option<&Bvh>,
        views: &[Receivers<'_>],
    ) -> Result<Vec<Self>, Error> {
        views.iter().try_for_each(|view| view.check(config.size))?;
        views.iter().enumerate().map(|view| Self::new(gpu, config, scene, b, sort, view, bvh)).collect()
    }

    /// View `number`, which sees `receivers`.
    fn new(
        gpu: &Arc<Gpu>,
        config: &Config,
        scene: &SceneBuffers,
        b: &Buffers,
        sort: Option<&Sort>,
        (number, receivers): (usize, &Receivers<'_>),
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
        let gradient = |images: &ReceiverImages| Ok((*images, Gradient::new(gpu, frame, images, &buffers.receivers)?));
        Ok(Self {
            size,
            mask_use: receivers.mask,
            gradients: receivers.images.iter().map(gradient).collect::<Result<_, Error>>()?,
            request: Request::new(gpu, config, b, (number, &buffers), sort, size)?,
            lookup: Lookup::new(gpu, config, b, (number, &buffers), exact.as_ref())?,
            host_set: Lookup::host_set(gpu, b, number)?,
            exact,
            buffers,
        })
    }

    /// Fails for images that the view does not have.
    pub(crate) fn check_images(&self, images: usize) -> Result<(), Error> {
        let count = self.gradients.len();
        if images < count {
            return Ok(());
        }
        let (given, limit) = (images.to_string(), format!("0 to {}, as the view was made", count - 1));
        Err(Error::Limit { field: "images of a view", given, limit })
    }

    /// Takes the host's images, which the view has, from their last use to that again, and leaves the receivers to be read.
    pub(crate) fn record_gradient(&self, device: &ash::Device, cmd: vk::CommandBuffer, images: usize) {
        let (images, gradient) = &self.gradients[images];
        let seen = || [Some(images.depth), images.normal].into_iter().flatten();
        seen().for_each(|image| sync::host_image(device, cmd, &image, true));
        gradient.record(cmd, self.size);
        seen().for_each(|image| sync::host_image(device, cmd, &image, false));
        self.buffers.receivers.record_written(device, cmd);
    }
}
