//! Depth, geometric normal and base colour of what the camera sees. A host may bring its own depth and normals instead.
//! Reads: scene. Writes: depth (reversed), normal, albedo. No capacity.

use super::constants::camera_constants;
use crate::Error;
use crate::config::check_size;
use crate::gpu::HostDevice;
use crate::gpu::structs::Frame;
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Buffer, Gpu, Graphics, GraphicsState, Image, ImageSpec, Memory, Shaders, set_area, spirv};
use crate::host::{FrameInput, HostImage, ReceiverImages, SceneBuffers};
use ash::vk;
use std::sync::Arc;

/// One instanced draw: a mesh with all its instances.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MeshDraw {
    /// Number of indices.
    pub index_count: u32,
    /// First index.
    pub first_index: u32,
    /// Number of instances.
    pub instance_count: u32,
    /// First instance.
    pub first_instance: u32,
    /// Whether fragments are cut away by alpha.
    pub alpha_tested: bool,
}

/// The engine's own prepass for hosts that have no depth and normals to give.
pub struct DepthPrepass {
    pub(crate) depth: Image,
    pub(crate) normal: Image,
    pub(crate) albedo: Image,
    size: [u32; 2],
    frame: Buffer,
    opaque: Graphics,
    masked: Graphics,
    scene: SceneBuffers,
    gpu: Arc<Gpu>,
}

impl DepthPrepass {
    /// Makes images of `size` pixels, 1 to 16384 each, and the pipelines.
    ///
    /// # Errors
    /// As [`crate::Engine::new`].
    ///
    /// # Safety
    /// As [`crate::Engine::new`].
    pub unsafe fn new(host: &HostDevice, size: [u32; 2], scene: &SceneBuffers) -> Result<Self, Error> {
        // SAFETY: the caller vouches for the handles
        let gpu = unsafe { Gpu::new(host)? };
        Self::on(&gpu, size, scene)
    }

    pub(crate) fn on(gpu: &Arc<Gpu>, size: [u32; 2], scene: &SceneBuffers) -> Result<Self, Error> {
        use vk::ImageUsageFlags as I;
        check_size("size", size, [16384; 2])?;
        let [width, height] = size;
        let image = |name: &str, format, usage| {
            let usage = usage | I::SAMPLED | I::TRANSFER_SRC;
            Image::new(gpu, name, &ImageSpec { format, width, height, layers: 0, usage })
        };
        let usage = vk::BufferUsageFlags::UNIFORM_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
        let frame = Buffer::new(gpu, "camera constants", size_of::<Frame>() as u64, usage, Memory::Device)?;
        let bindings = [
            Binding::Uniform(&frame),
            Binding::External(scene.instances),
            Binding::External(scene.materials),
            Binding::External(scene.texels),
        ];
        let state = GraphicsState {
            positions: Some(scene.position_layout),
            attributes: true,
            colors: &[vk::Format::R32_UINT, vk::Format::R8G8B8A8_UNORM],
            depth_compare: vk::CompareOp::GREATER_OR_EQUAL,
            cull: vk::CullModeFlags::NONE,
        };
        let pipeline = |name, alpha_test: u32| {
            let (vertex, fragment) = (spirv!("engine/depth_prepass.vert"), spirv!("engine/depth_prepass.frag"));
            let shaders = Shaders { vertex, tessellation: None, fragment: Some(fragment), constants: &[alpha_test] };
            Graphics::new(gpu, name, &shaders, &bindings, &state)
        };
        Ok(Self {
            depth: image("depth", vk::Format::D32_SFLOAT, I::DEPTH_STENCIL_ATTACHMENT)?,
            normal: image("normal", vk::Format::R32_UINT, I::COLOR_ATTACHMENT)?,
            albedo: image("albedo", vk::Format::R8G8B8A8_UNORM, I::COLOR_ATTACHMENT)?,
            opaque: pipeline("depth_prepass", 0)?,
            masked: pipeline("depth_prepass_masked", 1)?,
            size,
            frame,
            scene: *scene,
            gpu: gpu.clone(),
        })
    }

    /// Depth and normals, as [`crate::Engine::new`] takes them.
    pub fn images(&self) -> ReceiverImages {
        let normal = Some(HostImage::own(&self.normal, vk::Format::R32_UINT));
        ReceiverImages { depth: HostImage::own(&self.depth, vk::Format::D32_SFLOAT), normal }
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Draws the scene; leaves depth, normal and albedo readable by compute shaders. The projection must have reversed
    /// depth.
    ///
    /// # Errors
    /// [`Error::Limit`] for a camera that [`crate::Engine::record`] refuses.
    ///
    /// # Safety
    /// `cmd` must be recording outside of rendering; frames must run in the order they were recorded.
    pub unsafe fn record(&self, cmd: vk::CommandBuffer, input: &FrameInput, draws: &[MeshDraw]) -> Result<(), Error> {
        let constants = camera_constants(self.size, input)?;
        use Access::*;
        let device = &self.gpu.device;
        self.gpu.begin_label(cmd, c"depth prepass");
        sync::barrier(device, cmd, &[(GraphicsRead, TransferWrite)]);
        // SAFETY: the command buffer is recording; the constants are smaller than 64 KiB
        unsafe { device.cmd_update_buffer(cmd, self.frame.raw, 0, bytemuck::bytes_of(&constants)) };
        sync::barrier(device, cmd, &[(TransferWrite, GraphicsRead)]);
        sync::discard(device, cmd, &self.depth, ComputeRead, DepthAttachment);
        sync::discard(device, cmd, &self.normal, ComputeRead, ColorAttachment);
        sync::discard(device, cmd, &self.albedo, ComputeRead, ColorAttachment);
        let target = |image: &Image, image_layout| {
            vk::RenderingAttachmentInfo::default()
                .image_view(image.view)
                .image_layout(image_layout)
                .load_op(vk::AttachmentLoadOp::CLEAR)
                .store_op(vk::AttachmentStoreOp::STORE)
        };
        let color_layout = vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL;
        let colors = [target(&self.normal, color_layout), target(&self.albedo, color_layout)];
        // clear values are all zero: depth 0 is the far end
        let depth = target(&self.depth, vk::ImageLayout::DEPTH_ATTACHMENT_OPTIMAL);
        let area = vk::Rect2D { offset: vk::Offset2D::default(), extent: self.depth.extent };
        let info = vk::RenderingInfo::default()
            .render_area(area)
            .layer_count(1)
            .color_attachments(&colors)
            .depth_attachment(&depth);
        // SAFETY: the command buffer is recording; buffers and images outlive the submission
        unsafe {
            device.cmd_begin_rendering(cmd, &info);
            set_area(device, cmd, area);
            device.cmd_bind_index_buffer(cmd, self.scene.indices, 0, vk::IndexType::UINT32);
            device.cmd_bind_vertex_buffers(cmd, 0, &self.scene.vertices(), &[0, 0]);
            for (pipeline, alpha_tested) in [(&self.opaque, false), (&self.masked, true)] {
                pipeline.bind(cmd);
                for d in draws.iter().filter(|d| d.alpha_tested == alpha_tested) {
                    device.cmd_draw_indexed(cmd, d.index_count, d.instance_count, d.first_index, 0, d.first_instance);
                }
            }
            device.cmd_end_rendering(cmd);
        }
        sync::image(device, cmd, &self.depth, DepthAttachment, ComputeRead);
        sync::image(device, cmd, &self.normal, ColorAttachment, ComputeRead);
        sync::image(device, cmd, &self.albedo, ColorAttachment, ComputeRead);
        self.gpu.end_label(cmd);
        Ok(())
    }
}
