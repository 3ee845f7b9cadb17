//! The depth and the plane of every pixel: distance along the view direction, geometric normal and world-space derivatives
//! per pixel. All later passes read these and not the host's images, which are free again after this one.
//! Reads: the host's depth and, where there are any, normals. Writes: planes (16 bytes a pixel) and depths (4). No capacity.

use crate::Error;
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Compute, Gpu, Image, ImageSpec, spirv};
use crate::host::ReceiverImages;
use ash::vk;
use std::sync::Arc;

/// What this pass leaves of a view.
pub(crate) struct Receivers {
    pub(crate) planes: Image,
    /// 0 where there is no surface.
    pub(crate) depth: Image,
}

impl Receivers {
    pub(crate) fn new(gpu: &Arc<Gpu>, [width, height]: [u32; 2]) -> Result<Self, Error> {
        use vk::ImageUsageFlags as U;
        let image = |name, format| {
            // tests copy from and to them
            let copied = if cfg!(feature = "lab") { U::TRANSFER_SRC | U::TRANSFER_DST } else { U::empty() };
            let usage = U::STORAGE | U::SAMPLED | copied;
            Image::new(gpu, name, &ImageSpec { format, width, height, layers: 0, usage })
        };
        Ok(Self {
            planes: image("receiver planes", vk::Format::R32G32B32A32_UINT)?,
            depth: image("receiver depths", vk::Format::R32_SFLOAT)?,
        })
    }

    fn images(&self) -> [&Image; 2] {
        [&self.planes, &self.depth]
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.images().iter().map(|image| image.bytes).sum()
    }

    /// Readies them for the pass.
    pub(crate) fn record_discard(&self, device: &ash::Device, cmd: vk::CommandBuffer) {
        for image in self.images() {
            sync::discard(device, cmd, image, Access::ComputeRead, Access::StorageImage);
        }
    }

    /// Readies them for those that read.
    pub(crate) fn record_written(&self, device: &ash::Device, cmd: vk::CommandBuffer) {
        for image in self.images() {
            sync::image(device, cmd, image, Access::StorageImage, Access::ComputeRead);
        }
    }
}

pub(crate) struct Gradient(Compute);

impl Gradient {
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        frame: Binding<'_>,
        images: &ReceiverImages,
        receivers: &Receivers,
    ) -> Result<Self, Error> {
        let [planes, depth] = receivers.images().map(Binding::StorageImage);
        let common = [frame, Binding::SampledView(images.depth.view, images.depth.sampled_layout()), planes, depth];
        Ok(Self(match &images.normal {
            Some(normal) => {
                let normal = Binding::SampledView(normal.view, normal.sampled_layout());
                let bindings = [common.as_slice(), &[normal]].concat();
                Compute::new(gpu, "gradient", spirv!("engine/gradient.comp"), &bindings, &[], 0)?
            }
            None => Compute::new(gpu, "gradient_depth", spirv!("engine/gradient_depth.comp"), &common, &[], 0)?,
        }))
    }

    pub(crate) fn record(&self, cmd: vk::CommandBuffer, size: [u32; 2]) {
        self.0.dispatch(cmd, &(), [size[0].div_ceil(8), size[1].div_ceil(8), 1]);
    }
}
