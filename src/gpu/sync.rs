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
    /// Read through a descriptor in a vertex or fragment shader.
    GraphicsRead,
    /// The same there or in a compute shader: what a host may look up in its own shaders.
    LookupRead,
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
                S::VERTEX_SHADER | S::FRAGMENT_SHADER,
                A::SHADER_STORAGE_READ | A::SHADER_SAMPLED_READ | A::UNIFORM_READ,
            ),
            Access::LookupRead => {
                let (graphics, compute) = (Access::GraphicsRead.scope(), Access::ComputeRead.scope());
                (graphics.0 | compute.0, graphics.1 | compute.1)
            }
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

fn transition(
    device: &ash::Device,
    cmd: vk::CommandBuffer,
    (image, range): (vk::Image, vk::ImageSubresourceRange),
    before: Access,
    after: Access,
) {
    let ((src_stage, src_access), (dst_stage, dst_access)) = (before.scope(), after.scope());
    let barrier = [vk::ImageMemoryBarrier2::default()
        .src_stage_mask(src_stage)
        .src_access_mask(src_access)
        .dst_stage_mask(dst_stage)
        .dst_access_mask(dst_access)
        .old_layout(before.layout())
        .new_layout(after.layout())
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
    let (host, own) =
        ((image.used.stage, image.used.access, image.used.layout), (stage, access, image.sampled_layout()));
    let (before, after) = if begin { (host, own) } else { (own, host) };
    let barrier = [vk::ImageMemoryBarrier2::default()
        .src_stage_mask(before.0)
        .src_access_mask(before.1 & WRITES)
        .dst_stage_mask(after.0)
        .dst_access_mask(after.1)
        .old_layout(before.2)
        .new_layout(after.2)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .image(image.image)
        .subresource_range(vk::ImageSubresourceRange {
            aspect_mask: image.aspect(),
            base_mip_level: 0,
            level_count: 1,
            base_array_layer: image.layer,
            layer_count: 1,
        })];
    // SAFETY: the command buffer is recording outside of rendering
    unsafe { device.cmd_pipeline_barrier2(cmd, &vk::DependencyInfo::default().image_memory_barriers(&barrier)) };
}

/// What the engine wrote as a storage image goes over to the host (`end`), or comes back with nothing in it to keep.
pub(crate) fn mask(device: &ash::Device, cmd: vk::CommandBuffer, image: &Image, used: &ImageUse, end: bool) {
    let (stage, access) = Access::StorageImage.scope();
    let barrier = vk::ImageMemoryBarrier2::default();
    let barrier = if end {
        let barrier = barrier.src_stage_mask(stage).src_access_mask(access).old_layout(L::GENERAL);
        barrier.dst_stage_mask(used.stage).dst_access_mask(used.access).new_layout(used.layout)
    } else {
        let barrier = barrier.src_stage_mask(used.stage).src_access_mask(used.access & WRITES).old_layout(L::UNDEFINED);
        barrier.dst_stage_mask(stage).dst_access_mask(access).new_layout(L::GENERAL)
    };
    let barrier = [barrier
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .image(image.raw)
        .subresource_range(image.range())];
    // SAFETY: the command buffer is recording outside of rendering
    unsafe { device.cmd_pipeline_barrier2(cmd, &vk::DependencyInfo::default().image_memory_barriers(&barrier)) };
}

/// Accesses of a host that change an image.
const WRITES: A = A::from_raw(
    A::SHADER_WRITE.as_raw()
        | A::SHADER_STORAGE_WRITE.as_raw()
        | A::COLOR_ATTACHMENT_WRITE.as_raw()
        | A::DEPTH_STENCIL_ATTACHMENT_WRITE.as_raw()
        | A::TRANSFER_WRITE.as_raw()
        | A::MEMORY_WRITE.as_raw(),
);

/// Forgets what an image holds after its last use as `last` and readies it for `next`.
pub(crate) fn discard(device: &ash::Device, cmd: vk::CommandBuffer, image: &Image, last: Access, next: Access) {
    let ((src_stage, _), (dst_stage, dst_access)) = (last.scope(), next.scope());
    let (_, src_access) = match last {
        Access::ComputeRead | Access::LookupRead | Access::TransferRead | Access::Nothing => (S::NONE, A::NONE),
        writer => writer.scope(),
    };
    let barrier = [vk::ImageMemoryBarrier2::default()
        .src_stage_mask(src_stage)
        .src_access_mask(src_access)
        .dst_stage_mask(dst_stage)
        .dst_access_mask(dst_access)
        .old_layout(L::UNDEFINED)
        .new_layout(next.layout())
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .image(image.raw)
        .subresource_range(image.range())];
    // SAFETY: the command buffer is recording outside of rendering
    unsafe { device.cmd_pipeline_barrier2(cmd, &vk::DependencyInfo::default().image_memory_barriers(&barrier)) };
}

#[cfg(feature = "window")]
/// Where swapchain images are first and last touched.
pub(crate) const ACQUIRED_STAGE: S = S::ALL_TRANSFER;

/// Where timestamps are taken.
pub(crate) const TIMESTAMP_STAGE: S = S::BOTTOM_OF_PIPE;
