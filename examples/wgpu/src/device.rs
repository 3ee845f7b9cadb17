//! A wgpu device on which Umbrage can run too, and the raw handles behind what both use.

use crate::{Result, SIZE, Vulkan};
use ash::vk;
use std::cell::RefCell;
use std::sync::atomic::{AtomicU32, Ordering};
use umbrage::HostDevice;

/// wgpu's device and queue, and the same device as Umbrage gets it.
pub struct Gpu {
    pub host: HostDevice,
    pub queue: wgpu::Queue,
    memory: vk::PhysicalDeviceMemoryProperties,
    made: RefCell<Vec<(vk::Buffer, vk::DeviceMemory)>>,
    pub device: wgpu::Device,
}

// SAFETY of all calls below: wgpu keeps instance and device alive as long as `device`; infos are complete
#[allow(clippy::undocumented_unsafe_blocks)]
impl Gpu {
    pub fn new() -> Result<Self> {
        let instance = wgpu::Instance::new(&wgpu::InstanceDescriptor {
            backends: wgpu::Backends::VULKAN,
            flags: wgpu::InstanceFlags::debugging(),
            ..Default::default()
        });
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
        let features = wgpu::Features::INDIRECT_FIRST_INSTANCE | wgpu::Features::MULTI_DRAW_INDIRECT_COUNT;
        let (device, queue) = unsafe {
            let hal = adapter.as_hal::<Vulkan>().ok_or("no Vulkan adapter")?;
            let (raw, physical_device) = (hal.shared_instance().raw_instance(), hal.raw_physical_device());
            if let Some(what) = umbrage::missing_features(raw, physical_device).first() {
                return Err(format!("the device lacks {what}").into());
            }
            // wgpu would switch features on by structs of its own, beside which that of Vulkan 1.2 must not stand, and
            // Umbrage needs `shaderOutputLayer` of it: so the device is made here, with all that it has, and given to wgpu
            let mut vulkan11 = vk::PhysicalDeviceVulkan11Features::default();
            let mut vulkan12 = vk::PhysicalDeviceVulkan12Features::default();
            let mut vulkan13 = vk::PhysicalDeviceVulkan13Features::default();
            let mut available = vk::PhysicalDeviceFeatures2::default()
                .push_next(&mut vulkan11)
                .push_next(&mut vulkan12)
                .push_next(&mut vulkan13);
            raw.get_physical_device_features2(physical_device, &mut available);
            let extensions = hal.required_device_extensions(features);
            let names: Vec<_> = extensions.iter().map(|name| name.as_ptr()).collect();
            let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(0).queue_priorities(&[1.0])];
            let info = vk::DeviceCreateInfo::default()
                .queue_create_infos(&queues)
                .enabled_extension_names(&names)
                .push_next(&mut available);
            let device = raw.create_device(physical_device, &info, None)?;
            let hints = wgpu::MemoryHints::default();
            let open = hal.device_from_raw(device, None, &extensions, features, &hints, 0, 0)?;
            drop(hal);
            let required_limits = adapter.limits();
            let descriptor =
                wgpu::DeviceDescriptor { required_features: features, required_limits, ..Default::default() };
            adapter.create_device_from_hal::<Vulkan>(open, &descriptor)?
        };
        let (host, memory) = unsafe {
            let hal = device.as_hal::<Vulkan>().ok_or("no Vulkan device")?;
            let instance = hal.shared_instance().raw_instance().clone();
            let physical_device = hal.raw_physical_device();
            let memory = instance.get_physical_device_memory_properties(physical_device);
            let device = hal.raw_device().clone();
            (HostDevice { instance, physical_device, device, debug_utils: true, ray_query: false }, memory)
        };
        Ok(Self { host, queue, memory, made: RefCell::default(), device })
    }

    /// A buffer that the CPU filled.
    pub fn buffer(&self, bytes: &[u8], usage: vk::BufferUsageFlags) -> Result<vk::Buffer> {
        use vk::MemoryPropertyFlags as M;
        unsafe {
            let device = &self.host.device;
            let size = bytes.len() as u64;
            let buffer = device.create_buffer(&vk::BufferCreateInfo::default().size(size).usage(usage), None)?;
            let needs = device.get_buffer_memory_requirements(buffer);
            let wanted = M::HOST_VISIBLE | M::HOST_COHERENT;
            let fits = |&(i, t): &(usize, &vk::MemoryType)| {
                needs.memory_type_bits & 1 << i != 0 && t.property_flags.contains(wanted)
            };
            let types = self.memory.memory_types_as_slice().iter().enumerate();
            let index = types.into_iter().find(fits).ok_or("no such memory")?.0 as u32;
            let info = vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(index);
            let memory = device.allocate_memory(&info, None)?;
            self.made.borrow_mut().push((buffer, memory));
            device.bind_buffer_memory(buffer, memory, 0)?;
            let to = device.map_memory(memory, 0, size, vk::MemoryMapFlags::empty())?;
            std::ptr::copy_nonoverlapping(bytes.as_ptr(), to.cast(), bytes.len());
            device.unmap_memory(memory);
            Ok(buffer)
        }
    }

    /// The same buffer for wgpu, which destroys it.
    pub fn lend(&self, buffer: vk::Buffer, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        let descriptor = wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false };
        self.made.borrow_mut().iter_mut().filter(|made| made.0 == buffer).for_each(|made| made.0 = vk::Buffer::null());
        unsafe {
            let hal = wgpu::hal::vulkan::Buffer::from_raw(buffer);
            self.device.create_buffer_from_hal::<Vulkan>(hal, &descriptor)
        }
    }

    pub fn raw_texture(&self, texture: &wgpu::Texture) -> Result<vk::Image> {
        Ok(unsafe { texture.as_hal::<Vulkan>().ok_or("no Vulkan texture")?.raw_handle() })
    }

    pub fn raw_view(&self, view: &wgpu::TextureView) -> Result<vk::ImageView> {
        Ok(unsafe { view.as_hal::<Vulkan>().ok_or("no Vulkan view")?.raw_handle() })
    }

    /// A command buffer of wgpu that only `record` fills.
    pub fn raw_encoder(&self, record: impl FnOnce(vk::CommandBuffer)) -> Result<wgpu::CommandBuffer> {
        let mut encoder =
            self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("shadows") });
        unsafe {
            encoder.as_hal_mut::<Vulkan, _, Result<()>>(|hal| {
                record(hal.ok_or("no Vulkan encoder")?.raw_handle());
                Ok(())
            })?;
        }
        Ok(encoder.finish())
    }

    /// Copies Umbrage's mask into a buffer that wgpu's shaders read.
    pub fn copy_mask(&self, cmd: vk::CommandBuffer, mask: vk::Image, to: vk::Buffer) {
        use vk::{AccessFlags2 as A, PipelineStageFlags2 as S};
        let barrier = |from: (S, A), to: (S, A)| {
            let barrier = vk::MemoryBarrier2::default().src_stage_mask(from.0).src_access_mask(from.1);
            let barrier = [barrier.dst_stage_mask(to.0).dst_access_mask(to.1)];
            let info = vk::DependencyInfo::default().memory_barriers(&barrier);
            unsafe { self.host.device.cmd_pipeline_barrier2(cmd, &info) };
        };
        let (read, write) = ((S::COMPUTE_SHADER, A::SHADER_STORAGE_READ), (S::ALL_TRANSFER, A::TRANSFER_WRITE));
        barrier((read.0, A::NONE), write);
        let aspect_mask = vk::ImageAspectFlags::COLOR;
        let layers = vk::ImageSubresourceLayers { aspect_mask, layer_count: 1, ..Default::default() };
        let extent = vk::Extent3D { width: SIZE[0], height: SIZE[1], depth: 1 };
        let region = [vk::BufferImageCopy::default().image_subresource(layers).image_extent(extent)];
        let layout = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
        unsafe { self.host.device.cmd_copy_image_to_buffer(cmd, mask, layout, to, &region) };
        barrier(write, read);
    }

    /// Waits for everything that was submitted.
    pub fn wait(&self) -> Result<()> {
        self.device.poll(wgpu::PollType::wait_indefinitely())?;
        Ok(())
    }
}

#[allow(clippy::undocumented_unsafe_blocks)] // as above
impl Drop for Gpu {
    fn drop(&mut self) {
        unsafe {
            let device = &self.host.device;
            // wgpu destroys what was dropped when it is polled
            let _ = self.device.poll(wgpu::PollType::wait_indefinitely());
            for (buffer, memory) in self.made.take() {
                device.destroy_buffer(buffer, None);
                device.free_memory(memory, None);
            }
        }
    }
}

static ERRORS: AtomicU32 = AtomicU32::new(0);

/// Errors that wgpu logged, those of the validation layers among them.
pub fn errors() -> u32 {
    ERRORS.load(Ordering::Relaxed)
}

/// Prints and counts them from now on.
pub fn log_errors() {
    struct Logger;
    impl log::Log for Logger {
        fn enabled(&self, metadata: &log::Metadata<'_>) -> bool {
            metadata.level() <= log::Level::Error
        }
        fn log(&self, record: &log::Record<'_>) {
            let text = record.args().to_string();
            // layers older than naga do not know WGSL as the source language of debug information; a list of objects
            // follows each message
            let known = text.contains("Invalid source language operand") || text.trim_start().starts_with("objects:");
            if self.enabled(record.metadata()) && !known {
                eprintln!("{}: {text}", record.target());
                ERRORS.fetch_add(1, Ordering::Relaxed);
            }
        }
        fn flush(&self) {}
    }
    if log::set_logger(&Logger).is_ok() {
        log::set_max_level(log::LevelFilter::Error);
    }
}
