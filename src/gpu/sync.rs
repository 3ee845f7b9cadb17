//! The only file that names pipeline stages and access masks: barriers are pairs of named accesses.

use super::Image;
use crate::host::{HostImage, ImageUse};
use ash::vk;
use vk::{AccessFlags2 as A, ImageLayout as L, PipelineStageFlags2 as S};

/// One way of touching a resource.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Access {
    #[cfg_attr(not(feature = "lab"), allow(dead_code))] // the lab uses it
    /// Nothing happened yet, or the content is not needed any more.
    Nothing,
    ComputeRead,
    ComputeWrite,
    /// A storage image read or written by a compute shader.
    StorageImage,
    IndirectRead,
    /// Read through a descriptor in a shader of a graphics pipeline, be it the host's.
    GraphicsRead,
    /// The same there or in a compute shader: what a host may look up in its own shaders.
    LookupRead,
    #[cfg_attr(not(feature = "lab"), allow(dead_code))] // the lab uses it
    /// Read and written through a descriptor in a fragment shader.
    FragmentWrite,
    IndexRead,
    DepthAttachment,
    ColorAttachment,
    TransferRead,
    TransferWrite,
    /// An acceleration structure is built: what it is made of is read.
    StructureBuild,
    /// Traversed by a ray query in a compute shader.
    StructureRead,
    HostRead,
    #[cfg_attr(not(feature = "lab"), allow(dead_code))] // the lab uses it
    HostWrite,
    #[cfg(feature = "window")]
    /// A swapchain image once its semaphore was waited for in [`ACQUIRED_STAGE`]; what it holds is not needed.
    Acquired,
    #[cfg(feature = "window")]
    /// A swapchain image given to the presentation engine by a semaphore that is signalled after [`ACQUIRED_STAGE`].
    Presented,
}

impl Access {
    fn scope(self) -> (S, A) {
        match self {
            Access::Nothing => (S::TOP_OF_PIPE, A::NONE),
            Access::ComputeRead => {
                (S::COMPUTE_SHADER, A::SHADER_STORAGE_READ | A::SHADER_SAMPLED_READ | A::UNIFORM_READ)
            }
            Access::ComputeWrite | Access::StorageImage => {
                (S::COMPUTE_SHADER, A::SHADER_STORAGE_READ | A::SHADER_STORAGE_WRITE)
            }
            Access::IndirectRead => (S::DRAW_INDIRECT, A::INDIRECT_COMMAND_READ),
            Access::GraphicsRead => (
                S::PRE_RASTERIZATION_SHADERS | S::FRAGMENT_SHADER,
                A::SHADER_STORAGE_READ | A::SHADER_SAMPLED_READ | A::UNIFORM_READ,
            ),
            Access::LookupRead => {
                let (graphics, compute) = (Access::GraphicsRead.scope(), Access::ComputeRead.scope());
                (graphics.0 | compute.0, graphics.1 | compute.1)
            }
            Access::FragmentWrite => (S::FRAGMENT_SHADER, A::SHADER_STORAGE_READ | A::SHADER_STORAGE_WRITE),
            Access::IndexRead => (S::INDEX_INPUT, A::INDEX_READ),
            Access::DepthAttachment => (
                S::EARLY_FRAGMENT_TESTS | S::LATE_FRAGMENT_TESTS,
                A::DEPTH_STENCIL_ATTACHMENT_READ | A::DEPTH_STENCIL_ATTACHMENT_WRITE,
            ),
            Access::ColorAttachment => (S::COLOR_ATTACHMENT_OUTPUT, A::COLOR_ATTACHMENT_WRITE),
            Access::TransferRead => (S::ALL_TRANSFER, A::TRANSFER_READ),
            Access::TransferWrite => (S::ALL_TRANSFER, A::TRANSFER_WRITE),
            Access::StructureBuild => (
                S::ACCELERATION_STRUCTURE_BUILD_KHR,
                A::ACCELERATION_STRUCTURE_READ_KHR | A::ACCELERATION_STRUCTURE_WRITE_KHR | A::SHADER_READ,
            ),
            Access::StructureRead => (S::COMPUTE_SHADER, A::ACCELERATION_STRUCTURE_READ_KHR),
            Access::HostRead => (S::HOST, A::HOST_READ),
            Access::HostWrite => (S::HOST, A::HOST_WRITE),
            #[cfg(feature = "window")]
            Access::Acquired | Access::Presented => (ACQUIRED_STAGE, A::NONE),
        }
    }

    fn side(self) -> Side {
        let (stage, access) = self.scope();
        (stage, access, self.layout())
    }

    fn layout(self) -> L {
        match self {
            Access::Nothing => L::UNDEFINED,
            Access::StorageImage => L::GENERAL,
            Access::DepthAttachment => L::DEPTH_ATTACHMENT_OPTIMAL,
            Access::ColorAttachment => L::COLOR_ATTACHMENT_OPTIMAL,
            Access::TransferRead => L::TRANSFER_SRC_OPTIMAL,
            Access::TransferWrite => L::TRANSFER_DST_OPTIMAL,
            #[cfg(feature = "window")]
            Access::Acquired => L::UNDEFINED,
            #[cfg(feature = "window")]
            Access::Presented => L::PRESENT_SRC_KHR,
            _ => L::SHADER_READ_ONLY_OPTIMAL,
        }
    }
}

/// The layout in which a sampled image is bound.
pub(crate) const SAMPLED: L = L::SHADER_READ_ONLY_OPTIMAL;

/// Orders all buffer accesses of the first kind before those of the second, for each pair.
pub(crate) fn barrier(device: &ash::Device, cmd: vk::CommandBuffer, pairs: &[(Access, Access)]) {
    let mut barriers = [vk::MemoryBarrier2::default(); 8];
    debug_assert!(pairs.len() <= barriers.len());
    for (slot, (before, after)) in barriers.iter_mut().zip(pairs) {
        let ((src_stage, src_access), (dst_stage, dst_access)) = (before.scope(), after.scope());
        *slot = vk::MemoryBarrier2::default()
            .src_stage_mask(src_stage)
            .src_access_mask(src_access)
            .dst_stage_mask(dst_stage)
            .dst_access_mask(dst_access);
    }
    let info = vk::DependencyInfo::default().memory_barriers(&barriers[..pairs.len()]);
    // SAFETY: the command buffer is recording outside of rendering
    unsafe { device.cmd_pipeline_barrier2(cmd, &info) };
}

/// Moves a whole image from one access to another, with the layouts these accesses need.
pub(crate) fn image(device: &ash::Device, cmd: vk::CommandBuffer, image: &Image, before: Access, after: Access) {
    transition(device, cmd, (image.raw, image.range()), before, after);
}

#[cfg(feature = "window")]
/// The same for an image of a swapchain.
pub(crate) fn swapchain_image(
    device: &ash::Device,
    cmd: vk::CommandBuffer,
    image: vk::Image,
    before: Access,
    after: Access,
) {
    let range = vk::ImageSubresourceRange {
        aspect_mask: vk::ImageAspectFlags::COLOR,
        base_mip_level: 0,
        level_count: 1,
        base_array_layer: 0,
        layer_count: 1,
    };
    transition(device, cmd, (image, range), before, after);
}

/// Stages, accesses and layout on one side of a barrier.
type Side = (S, A, L);

fn transition(
    device: &ash::Device,
    cmd: vk::CommandBuffer,
    image: (vk::Image, vk::ImageSubresourceRange),
    before: Access,
    after: Access,
) {
    image_barrier(device, cmd, image, before.side(), after.side());
}

fn image_barrier(
    device: &ash::Device,
    cmd: vk::CommandBuffer,
    (image, range): (vk::Image, vk::ImageSubresourceRange),
    before: Side,
    after: Side,
) {
    let barrier = [vk::ImageMemoryBarrier2::default()
        .src_stage_mask(before.0)
        .src_access_mask(before.1)
        .dst_stage_mask(after.0)
        .dst_access_mask(after.1)
        .old_layout(before.2)
        .new_layout(after.2)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .image(image)
        .subresource_range(range)];
    // SAFETY: the command buffer is recording outside of rendering
    unsafe { device.cmd_pipeline_barrier2(cmd, &vk::DependencyInfo::default().image_memory_barriers(&barrier)) };
}

/// Makes an image of the host readable by compute shaders (`begin`), or gives it back.
pub(crate) fn host_image(device: &ash::Device, cmd: vk::CommandBuffer, image: &HostImage, begin: bool) {
    let (stage, access) = Access::ComputeRead.scope();
    let own = (stage, access, image.sampled_layout());
    let host = image.used.side();
    let (before, after) = if begin { (host, own) } else { (own, host) };
    let range = vk::ImageSubresourceRange {
        aspect_mask: image.aspect(),
        base_mip_level: 0,
        level_count: 1,
        base_array_layer: image.layer,
        layer_count: 1,
    };
    image_barrier(device, cmd, (image.image, range), before, after);
}

/// What the engine wrote as a storage image goes over to the host (`end`), or comes back with nothing in it to keep.
pub(crate) fn mask(device: &ash::Device, cmd: vk::CommandBuffer, image: &Image, used: &ImageUse, end: bool) {
    let (own, host) = (Access::StorageImage.side(), used.side());
    let (before, after) = if end { (own, host) } else { ((host.0, host.1, L::UNDEFINED), own) };
    image_barrier(device, cmd, (image.raw, image.range()), before, after);
}

impl ImageUse {
    fn side(&self) -> Side {
        (self.stage, self.access, self.layout)
    }
}

/// Forgets what an image holds after its last use as `last` and readies it for `next`.
pub(crate) fn discard(device: &ash::Device, cmd: vk::CommandBuffer, image: &Image, last: Access, next: Access) {
    let (src_stage, _) = last.scope();
    let (_, src_access) = match last {
        Access::ComputeRead | Access::LookupRead | Access::TransferRead | Access::Nothing => (S::NONE, A::NONE),
        writer => writer.scope(),
    };
    let before = (src_stage, src_access, L::UNDEFINED);
    image_barrier(device, cmd, (image.raw, image.range()), before, next.side());
}

#[cfg(feature = "window")]
/// Where swapchain images are first and last touched.
pub(crate) const ACQUIRED_STAGE: S = S::ALL_TRANSFER;

/// Where timestamps are taken.
pub(crate) const TIMESTAMP_STAGE: S = S::BOTTOM_OF_PIPE;
