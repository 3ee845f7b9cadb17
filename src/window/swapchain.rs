//! The images that the window shows: made, made again when window or surface change, and presented.

use super::Pace;
use super::surface::present_on;
use crate::Error;
use crate::error::Context;
use crate::gpu::sync;
use crate::lab::LabError;
use crate::lab::device::{LabDevice, Surface};
use ash::vk;
use std::sync::Arc;
use winit::window::Window;

/// Longest wait for an image, in nanoseconds; compositors give none to windows that nobody sees.
const PATIENCE_NS: u64 = 1_000_000_000;

/// An image to draw into while the picture is recorded.
pub(super) struct Target {
    pub(super) image: vk::Image,
    pub(super) extent: vk::Extent2D,
}

pub(super) struct Swapchain {
    raw: vk::SwapchainKHR,
    images: Vec<vk::Image>,
    extent: vk::Extent2D,
    /// Window or surface have changed since it was made.
    stale: bool,
    functions: ash::khr::swapchain::Device,
    pace: Pace,
    acquired: vk::Semaphore,
    /// By image: an image that is acquired again has been presented, so that its semaphore is free.
    finished: Vec<vk::Semaphore>,
    fence: vk::Fence,
    pool: vk::CommandPool,
    cmd: vk::CommandBuffer,
    /// `None` only while a lost one is replaced.
    surface: Option<Surface>,
    device: Arc<LabDevice>,
    window: Arc<Window>,
}

impl Swapchain {
    /// Nothing is made for the window's size before the first picture.
    pub(super) fn new(
        device: &Arc<LabDevice>,
        surface: Surface,
        window: &Arc<Window>,
        pace: Pace,
    ) -> Result<Self, LabError> {
        let handles = &device.handles;
        let mut this = Self {
            raw: vk::SwapchainKHR::null(),
            images: Vec::new(),
            extent: vk::Extent2D::default(),
            stale: true,
            functions: ash::khr::swapchain::Device::new(&handles.instance, &handles.device),
            pace,
            acquired: vk::Semaphore::null(),
            finished: Vec::new(),
            fence: vk::Fence::null(),
            pool: vk::CommandPool::null(),
            cmd: vk::CommandBuffer::null(),
            surface: Some(surface),
            device: device.clone(),
            window: window.clone(),
        };
        let vulkan = &handles.device;
        // SAFETY: plain create calls with complete infos; `Drop` frees what was made when a later one fails
        unsafe {
            let info = vk::CommandPoolCreateInfo::default()
                .queue_family_index(device.family())
                .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
            this.pool = vulkan.create_command_pool(&info, None).context("vkCreateCommandPool")?;
            let info = vk::CommandBufferAllocateInfo::default().command_pool(this.pool).command_buffer_count(1);
            this.cmd = vulkan.allocate_command_buffers(&info).context("vkAllocateCommandBuffers")?[0];
            this.fence = vulkan.create_fence(&vk::FenceCreateInfo::default(), None).context("vkCreateFence")?;
            this.acquired =
                vulkan.create_semaphore(&vk::SemaphoreCreateInfo::default(), None).context("vkCreateSemaphore")?;
        }
        Ok(this)
    }

    /// The window has another size: images are made again before the next picture.
    pub(super) fn outdated(&mut self) {
        self.stale = true;
    }

    /// Shows what `record` draws and waits until the device has drawn it. `false` where nothing could be shown: the window
    /// has no area or is not seen, or its images must be made again first.
    pub(super) fn show(&mut self, record: impl FnOnce(vk::CommandBuffer, &Target)) -> Result<bool, LabError> {
        if self.stale && !self.make()? {
            return Ok(false);
        }
        let null = vk::Fence::null();
        // SAFETY: swapchain and semaphore are alive, and the semaphore's last use was waited for
        let next = unsafe { self.functions.acquire_next_image(self.raw, PATIENCE_NS, self.acquired, null) };
        let index = match next {
            Ok((index, suboptimal)) => {
                self.stale |= suboptimal;
                index
            }
            Err(vk::Result::TIMEOUT | vk::Result::NOT_READY) => return Ok(false),
            Err(error) => return self.changed(error, "vkAcquireNextImageKHR").map(|()| false),
        };
        let at = index as usize;
        self.draw(&Target { image: self.images[at], extent: self.extent }, self.finished[at], record)?;
        let (waits, chains, indices) = ([self.finished[at]], [self.raw], [index]);
        let info = vk::PresentInfoKHR::default().wait_semaphores(&waits).swapchains(&chains).image_indices(&indices);
        // SAFETY: the image was acquired and drawn
        match unsafe { self.functions.queue_present(self.device.queue(), &info) } {
            Ok(suboptimal) => self.stale |= suboptimal,
            Err(error) => self.changed(error, "vkQueuePresentKHR")?,
        }
        Ok(true)
    }

    /// Records, submits and waits.
    fn draw(
        &self,
        target: &Target,
        finished: vk::Semaphore,
        record: impl FnOnce(vk::CommandBuffer, &Target),
    ) -> Result<(), Error> {
        let (device, cmd) = (&self.device.handles.device, self.cmd);
        let info = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the command buffer's last submission was waited for; all infos are complete
        unsafe {
            device.begin_command_buffer(cmd, &info).context("vkBeginCommandBuffer")?;
            record(cmd, target);
            device.end_command_buffer(cmd).context("vkEndCommandBuffer")?;
            device.reset_fences(&[self.fence]).context("vkResetFences")?;
            let at =
                |semaphore| vk::SemaphoreSubmitInfo::default().semaphore(semaphore).stage_mask(sync::ACQUIRED_STAGE);
            let (waits, signals) = ([at(self.acquired)], [at(finished)]);
            let commands = [vk::CommandBufferSubmitInfo::default().command_buffer(cmd)];
            let submit = [vk::SubmitInfo2::default()
                .wait_semaphore_infos(&waits)
                .command_buffer_infos(&commands)
                .signal_semaphore_infos(&signals)];
            device.queue_submit2(self.device.queue(), &submit, self.fence).context("vkQueueSubmit2")?;
            device.wait_for_fences(&[self.fence], true, u64::MAX).context("vkWaitForFences")
        }
    }

    /// What a failure of the presentation engine asks for.
    fn changed(&mut self, result: vk::Result, call: &'static str) -> Result<(), LabError> {
        match result {
            vk::Result::ERROR_OUT_OF_DATE_KHR => self.stale = true,
            vk::Result::ERROR_SURFACE_LOST_KHR => {
                self.free_images();
                self.surface = None;
                let instance = self.device.instance();
                self.surface = Some(present_on(&self.window, |present| Surface::new(instance, present))?);
                self.stale = true;
            }
            error => return Err(Error::Vulkan { call, result: error }.into()),
        }
        Ok(())
    }

    /// Makes images of the window's size; `false` while it has no area.
    fn make(&mut self) -> Result<bool, LabError> {
        let Some(surface) = &self.surface else { return Ok(false) };
        let physical = self.device.handles.physical_device;
        let (functions, raw) = (&surface.functions, surface.raw);
        // SAFETY: surface and device are alive
        let queried = unsafe {
            (
                functions.get_physical_device_surface_capabilities(physical, raw),
                functions.get_physical_device_surface_formats(physical, raw),
                functions.get_physical_device_surface_present_modes(physical, raw),
            )
        };
        let limits = match queried.0 {
            Ok(limits) => limits,
            Err(error) => return self.changed(error, "vkGetPhysicalDeviceSurfaceCapabilitiesKHR").map(|()| false),
        };
        let formats = queried.1.context("vkGetPhysicalDeviceSurfaceFormatsKHR")?;
        let modes = queried.2.context("vkGetPhysicalDeviceSurfacePresentModesKHR")?;
        let extent = extent(&limits, self.window.inner_size().into());
        if extent.width == 0 || extent.height == 0 {
            return Ok(false);
        }
        if !limits.supported_usage_flags.contains(vk::ImageUsageFlags::TRANSFER_DST) {
            return Err(LabError::Refused("the window's images cannot be copied into".into()));
        }
        let format = format(&formats)?;
        let info = vk::SwapchainCreateInfoKHR::default()
            .surface(raw)
            .min_image_count(image_count(&limits))
            .image_format(format.format)
            .image_color_space(format.color_space)
            .image_extent(extent)
            .image_array_layers(1)
            .image_usage(vk::ImageUsageFlags::TRANSFER_DST)
            .image_sharing_mode(vk::SharingMode::EXCLUSIVE)
            .pre_transform(limits.current_transform)
            .composite_alpha(alpha(limits.supported_composite_alpha))
            .present_mode(mode(self.pace, &modes)?)
            .clipped(true)
            .old_swapchain(self.raw);
        // SAFETY: the info is complete; the old swapchain's images are not in use, as pictures are waited for
        let made = unsafe { self.functions.create_swapchain(&info, None) };
        self.free_images();
        self.raw = match made {
            Ok(raw) => raw,
            Err(error) => return self.changed(error, "vkCreateSwapchainKHR").map(|()| false),
        };
        // SAFETY: the swapchain was just made
        self.images = unsafe { self.functions.get_swapchain_images(self.raw) }.context("vkGetSwapchainImagesKHR")?;
        for _ in &self.images {
            // SAFETY: a plain create call with a complete info
            let made = unsafe { self.device.handles.device.create_semaphore(&Default::default(), None) };
            self.finished.push(made.context("vkCreateSemaphore")?);
        }
        (self.extent, self.stale) = (extent, false);
        Ok(true)
    }

    fn free_images(&mut self) {
        self.images.clear();
        // SAFETY: the queue has presented all that was asked of it, so nothing uses semaphores or images
        unsafe {
            let device = &self.device.handles.device;
            let _ = device.queue_wait_idle(self.device.queue());
            self.finished.drain(..).for_each(|semaphore| device.destroy_semaphore(semaphore, None));
            self.functions.destroy_swapchain(self.raw, None);
        }
        self.raw = vk::SwapchainKHR::null();
    }
}

impl Drop for Swapchain {
    fn drop(&mut self) {
        self.free_images();
        // SAFETY: the queue is idle
        unsafe {
            let device = &self.device.handles.device;
            device.destroy_semaphore(self.acquired, None);
            device.destroy_fence(self.fence, None);
            device.destroy_command_pool(self.pool, None);
        }
    }
}

/// The surface's size, or the window's where the surface takes any.
fn extent(limits: &vk::SurfaceCapabilitiesKHR, [width, height]: [u32; 2]) -> vk::Extent2D {
    let (low, high) = (limits.min_image_extent, limits.max_image_extent);
    if limits.current_extent.width != u32::MAX {
        limits.current_extent
    } else if width == 0 || height == 0 {
        vk::Extent2D::default()
    } else {
        // `min` after `max`: a surface without area has no largest extent either
        vk::Extent2D { width: width.max(low.width).min(high.width), height: height.max(low.height).min(high.height) }
    }
}

/// One more than the least, so that one can be drawn while others wait for the screen.
fn image_count(limits: &vk::SurfaceCapabilitiesKHR) -> u32 {
    let most = if limits.max_image_count == 0 { u32::MAX } else { limits.max_image_count };
    (limits.min_image_count + 1).min(most)
}

/// Pictures come sRGB encoded, so the format must not encode again.
fn format(offered: &[vk::SurfaceFormatKHR]) -> Result<vk::SurfaceFormatKHR, LabError> {
    use vk::Format as F;
    let wanted = [F::B8G8R8A8_UNORM, F::R8G8B8A8_UNORM, F::A8B8G8R8_UNORM_PACK32, F::A2B10G10R10_UNORM_PACK32];
    let fits =
        |f: F| offered.iter().find(|o| o.format == f && o.color_space == vk::ColorSpaceKHR::SRGB_NONLINEAR).copied();
    wanted.into_iter().find_map(fits).ok_or_else(|| {
        let offered: Vec<_> = offered.iter().map(|o| format!("{:?}", o.format)).collect();
        LabError::Refused(format!(
            "the window's formats are {}, allowed is B8G8R8A8_UNORM or alike",
            offered.join(", ")
        ))
    })
}

fn alpha(supported: vk::CompositeAlphaFlagsKHR) -> vk::CompositeAlphaFlagsKHR {
    use vk::CompositeAlphaFlagsKHR as A;
    [A::OPAQUE, A::INHERIT, A::PRE_MULTIPLIED, A::POST_MULTIPLIED]
        .into_iter()
        .find(|&a| supported.contains(a))
        .unwrap_or(A::OPAQUE)
}

fn mode(pace: Pace, offered: &[vk::PresentModeKHR]) -> Result<vk::PresentModeKHR, LabError> {
    let name = |mode: &vk::PresentModeKHR| match *mode {
        vk::PresentModeKHR::FIFO => "fifo",
        vk::PresentModeKHR::MAILBOX => "mailbox",
        vk::PresentModeKHR::IMMEDIATE => "immediate",
        _ => "",
    };
    let wanted = match pace {
        Pace::Fifo => vk::PresentModeKHR::FIFO,
        Pace::Mailbox => vk::PresentModeKHR::MAILBOX,
        Pace::Immediate => vk::PresentModeKHR::IMMEDIATE,
    };
    if offered.contains(&wanted) {
        return Ok(wanted);
    }
    let offered: Vec<_> = offered.iter().map(name).filter(|name| !name.is_empty()).collect();
    Err(LabError::Usage(format!(
        "the present mode is {}, allowed on this window is {}",
        name(&wanted),
        offered.join(", ")
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(side: u32) -> vk::Extent2D {
        vk::Extent2D { width: side, height: side }
    }

    #[test]
    fn the_extent_is_the_surface_s_or_fits_it() {
        let any = vk::SurfaceCapabilitiesKHR {
            current_extent: square(u32::MAX),
            min_image_extent: square(16),
            max_image_extent: square(4096),
            ..Default::default()
        };
        assert_eq!(extent(&any, [100, 5000]), vk::Extent2D { width: 100, height: 4096 });
        assert_eq!(extent(&any, [1, 16]), square(16));
        assert_eq!(extent(&any, [0, 16]), square(0));
        let given = vk::SurfaceCapabilitiesKHR { current_extent: square(64), ..any };
        assert_eq!(extent(&given, [100, 100]), square(64));
        // minimised
        let none = vk::SurfaceCapabilitiesKHR { current_extent: square(0), max_image_extent: square(0), ..any };
        assert_eq!(extent(&none, [100, 100]), square(0));
    }

    #[test]
    fn images_are_as_many_as_the_surface_allows() {
        let limits = |min_image_count, max_image_count| {
            image_count(&vk::SurfaceCapabilitiesKHR { min_image_count, max_image_count, ..Default::default() })
        };
        assert_eq!([limits(2, 0), limits(2, 8), limits(3, 3)], [3, 3, 3]);
    }

    #[test]
    fn formats_that_encode_are_refused() {
        let offer = |format| vk::SurfaceFormatKHR { format, color_space: vk::ColorSpaceKHR::SRGB_NONLINEAR };
        let both = [offer(vk::Format::B8G8R8A8_SRGB), offer(vk::Format::R8G8B8A8_UNORM)];
        assert_eq!(format(&both).unwrap().format, vk::Format::R8G8B8A8_UNORM);
        assert!(format(&both[..1]).unwrap_err().to_string().contains("B8G8R8A8_SRGB"));
    }

    #[test]
    fn a_mode_that_is_not_offered_is_named() {
        let offered = [vk::PresentModeKHR::FIFO, vk::PresentModeKHR::IMMEDIATE];
        assert_eq!(mode(Pace::Immediate, &offered).unwrap(), vk::PresentModeKHR::IMMEDIATE);
        let text = mode(Pace::Mailbox, &offered).unwrap_err().to_string();
        assert!(text.contains("mailbox") && text.contains("fifo, immediate"), "{text}");
    }
}
