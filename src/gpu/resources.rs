//! Buffers and images that free themselves.

use super::Gpu;
use crate::error::{Context, Error};
use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use std::sync::Arc;

/// Where a buffer lives.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Memory {
    /// Device only.
    Device,
    #[cfg_attr(not(feature = "lab"), allow(dead_code))] // the lab uses it
    /// Written by the CPU, read by the GPU.
    Upload,
    /// Written by the GPU, read by the CPU.
    Readback,
}

/// A buffer with its memory.
pub(crate) struct Buffer {
    pub(crate) raw: vk::Buffer,
    pub(crate) size: u64,
    allocation: Option<Allocation>,
    gpu: Arc<Gpu>,
}

impl Buffer {
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        name: &str,
        size: u64,
        usage: vk::BufferUsageFlags,
        memory: Memory,
    ) -> Result<Self, Error> {
        let size = size.max(16).next_multiple_of(16);
        let storage_limit = u64::from(gpu.limits.max_storage_buffer_range);
        if usage.contains(vk::BufferUsageFlags::STORAGE_BUFFER) && size > storage_limit {
            return Err(Error::OutOfMemory {
                what: format!("{name} (a storage buffer may hold {storage_limit})"),
                bytes: size,
            });
        }
        let info = vk::BufferCreateInfo::default().size(size).usage(usage);
        // SAFETY: a plain create call with a complete info
        let raw = unsafe { gpu.device.create_buffer(&info, None) }.context("vkCreateBuffer")?;
        gpu.name(raw, name);
        // SAFETY: `raw` was just made on this device
        let requirements = unsafe { gpu.device.get_buffer_memory_requirements(raw) };
        let location = match memory {
            Memory::Device => MemoryLocation::GpuOnly,
            Memory::Upload => MemoryLocation::CpuToGpu,
            Memory::Readback => MemoryLocation::GpuToCpu,
        };
        let mut buffer = Self { raw, size, allocation: None, gpu: gpu.clone() };
        let allocation = allocate(gpu, name, requirements, location, true)?;
        // SAFETY: memory and offset come from the allocator for exactly these requirements
        unsafe { gpu.device.bind_buffer_memory(raw, allocation.memory(), allocation.offset()) }
            .context("vkBindBufferMemory")?;
        buffer.allocation = Some(allocation);
        Ok(buffer)
    }

    /// A device buffer for shaders that can also be filled and copied.
    pub(crate) fn storage(gpu: &Arc<Gpu>, name: &str, size: u64, extra: vk::BufferUsageFlags) -> Result<Self, Error> {
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::TRANSFER_DST
            | vk::BufferUsageFlags::TRANSFER_SRC
            | extra;
        Self::new(gpu, name, size, usage, Memory::Device)
    }

    /// Where the device finds it; it was made with `SHADER_DEVICE_ADDRESS`.
    pub(crate) fn address(&self) -> u64 {
        // SAFETY: the buffer is alive and bound
        unsafe { self.gpu.device.get_buffer_device_address(&vk::BufferDeviceAddressInfo::default().buffer(self.raw)) }
    }

    /// The mapped bytes; empty for device memory.
    pub(crate) fn bytes(&self) -> &[u8] {
        self.allocation.as_ref().and_then(Allocation::mapped_slice).unwrap_or(&[])
    }

    #[cfg_attr(not(feature = "lab"), allow(dead_code))] // the lab uses it
    /// The mapped bytes for writing; empty for device memory.
    pub(crate) fn bytes_mut(&mut self) -> &mut [u8] {
        self.allocation.as_mut().and_then(Allocation::mapped_slice_mut).unwrap_or(&mut [])
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        // SAFETY: the owner waits for the GPU before dropping resources
        unsafe { self.gpu.device.destroy_buffer(self.raw, None) };
        free(&self.gpu, self.allocation.take());
    }
}

/// All aspects of a format.
pub(crate) fn aspects(format: vk::Format) -> vk::ImageAspectFlags {
    use vk::Format as F;
    match format {
        F::D16_UNORM_S8_UINT | F::D24_UNORM_S8_UINT | F::D32_SFLOAT_S8_UINT => {
            vk::ImageAspectFlags::DEPTH | vk::ImageAspectFlags::STENCIL
        }
        F::D16_UNORM | F::X8_D24_UNORM_PACK32 | F::D32_SFLOAT => vk::ImageAspectFlags::DEPTH,
        _ => vk::ImageAspectFlags::COLOR,
    }
}

/// What an image looks like.
pub(crate) struct ImageSpec {
    pub(crate) format: vk::Format,
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// 0 makes a plain 2-D image, n >= 1 an array of n layers.
    pub(crate) layers: u32,
    pub(crate) usage: vk::ImageUsageFlags,
}

/// A 2-D image (or array) with memory and a full view.
pub(crate) struct Image {
    pub(crate) raw: vk::Image,
    pub(crate) view: vk::ImageView,
    aspects: vk::ImageAspectFlags,
    pub(crate) extent: vk::Extent2D,
    pub(crate) layers: u32,
    pub(crate) bytes: u64,
    allocation: Option<Allocation>,
    gpu: Arc<Gpu>,
}

impl Image {
    pub(crate) fn new(gpu: &Arc<Gpu>, name: &str, spec: &ImageSpec) -> Result<Self, Error> {
        let layers = spec.layers.max(1);
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(spec.format)
            .extent(vk::Extent3D { width: spec.width, height: spec.height, depth: 1 })
            .mip_levels(1)
            .array_layers(layers)
            .samples(vk::SampleCountFlags::TYPE_1)
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(spec.usage);
        // SAFETY: a plain create call with a complete info
        let raw = unsafe { gpu.device.create_image(&info, None) }.context("vkCreateImage")?;
        gpu.name(raw, name);
        // SAFETY: `raw` was just made on this device
        let requirements = unsafe { gpu.device.get_image_memory_requirements(raw) };
        let mut image = Self {
            raw,
            view: vk::ImageView::null(),
            aspects: aspects(spec.format),
            extent: vk::Extent2D { width: spec.width, height: spec.height },
            layers,
            bytes: requirements.size,
            allocation: None,
            gpu: gpu.clone(),
        };
        let allocation = allocate(gpu, name, requirements, MemoryLocation::GpuOnly, false)?;
        // SAFETY: memory and offset come from the allocator for exactly these requirements
        unsafe { gpu.device.bind_image_memory(raw, allocation.memory(), allocation.offset()) }
            .context("vkBindImageMemory")?;
        image.allocation = Some(allocation);
        let kind = if spec.layers == 0 { vk::ImageViewType::TYPE_2D } else { vk::ImageViewType::TYPE_2D_ARRAY };
        let view = vk::ImageViewCreateInfo::default()
            .image(raw)
            .view_type(kind)
            .format(spec.format)
            .subresource_range(vk::ImageSubresourceRange { aspect_mask: image.aspect(), ..image.range() });
        // SAFETY: the image is bound and the range covers it
        image.view = unsafe { gpu.device.create_image_view(&view, None) }.context("vkCreateImageView")?;
        gpu.name(image.view, name);
        Ok(image)
    }

    /// What is sampled and copied: without stencil.
    pub(crate) fn aspect(&self) -> vk::ImageAspectFlags {
        self.aspects & !vk::ImageAspectFlags::STENCIL
    }

    pub(crate) fn range(&self) -> vk::ImageSubresourceRange {
        vk::ImageSubresourceRange {
            aspect_mask: self.aspects,
            base_mip_level: 0,
            level_count: 1,
            base_array_layer: 0,
            layer_count: self.layers,
        }
    }
}

impl Drop for Image {
    fn drop(&mut self) {
        // SAFETY: the owner waits for the GPU before dropping resources
        unsafe {
            self.gpu.device.destroy_image_view(self.view, None);
            self.gpu.device.destroy_image(self.raw, None);
        }
        free(&self.gpu, self.allocation.take());
    }
}

fn allocate(
    gpu: &Gpu,
    name: &str,
    requirements: vk::MemoryRequirements,
    location: MemoryLocation,
    linear: bool,
) -> Result<Allocation, Error> {
    let out_of_memory = || Error::OutOfMemory { what: name.to_owned(), bytes: requirements.size };
    let mut allocator = gpu.allocator.lock().map_err(|_| out_of_memory())?;
    let desc = AllocationCreateDesc {
        name,
        requirements,
        location,
        linear,
        allocation_scheme: AllocationScheme::GpuAllocatorManaged,
    };
    allocator.as_mut().ok_or_else(out_of_memory)?.allocate(&desc).map_err(|_| out_of_memory())
}

fn free(gpu: &Gpu, allocation: Option<Allocation>) {
    if let (Some(allocation), Ok(mut allocator)) = (allocation, gpu.allocator.lock())
        && let Some(allocator) = allocator.as_mut()
    {
        // freeing an allocation of this allocator cannot fail
        let _ = allocator.free(allocation);
    }
}
