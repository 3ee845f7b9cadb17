//! The triangle under each pixel: what a sample lies on does not shadow it, in [`super::izb`], with `bias=ids` and in
//! [`super::triangle_store`]. And the draws whose shaders fetch vertices themselves, because they ask for more than one of a
//! triangle.

use super::map::{self, Screen};
use crate::engine::depth_prepass::MeshDraw;
use crate::engine::exact::hit_bindings;
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Compute, Graphics, GraphicsState, Image, Shaders, set_area, spirv};
use crate::host::SceneBuffers;
use crate::lab::{Lab, LabError};
use ash::vk;

/// Finds the triangle under each pixel, and puts samples of small pixels exactly onto it.
pub(super) struct Owners {
    /// Instance, and triangle of the scene + 1.
    pub(super) image: Image,
    depth: Image,
    /// Without and with alpha test.
    draws: [Graphics; 2],
    snap: Compute,
}

impl Owners {
    pub(super) fn new(lab: &Lab, screen: &Screen) -> Result<Self, LabError> {
        use vk::ImageUsageFlags as I;
        let (gpu, scene) = (lab.gpu(), lab.scene_buffers());
        let image = map::screen_image(lab, "owners", vk::Format::R32G32_UINT, I::COLOR_ATTACHMENT | I::SAMPLED)?;
        let depth = map::screen_image(lab, "owners' depth", vk::Format::D32_SFLOAT, I::DEPTH_STENCIL_ATTACHMENT)?;
        let bindings =
            [&[Binding::Uniform(&screen.frame)], &hit_bindings(scene)[..], &[Binding::External(scene.indices)]]
                .concat();
        let [stride, offset, format] = scene.position_layout.words();
        let state = GraphicsState {
            colors: &[vk::Format::R32G32_UINT],
            depth: true,
            depth_compare: vk::CompareOp::GREATER_OR_EQUAL,
            ..bare(scene)
        };
        let draw = |masked: bool| {
            let (vertex, fragment) = (spirv!("methods/izb_owner.vert"), spirv!("methods/izb_owner.frag"));
            let constants = &[stride, offset, format, u32::from(masked)];
            let shaders = Shaders { vertex, tessellation: None, fragment: Some(fragment), constants };
            Graphics::new(gpu, "izb_owner", &shaders, &bindings, &state)
        };
        let seen = [Binding::Sampled(&image), Binding::StorageImage(&screen.receivers.depth)];
        let bindings = [&bindings[..], &seen].concat();
        let snap = spirv!("methods/izb_snap.comp");
        Ok(Self {
            draws: [draw(false)?, draw(true)?],
            snap: Compute::new(gpu, "izb_snap", snap, &bindings, &[stride, offset, format], 0)?,
            image,
            depth,
        })
    }

    pub(super) fn bytes(&self) -> u64 {
        self.image.bytes + self.depth.bytes
    }

    /// After the receivers were written.
    pub(super) fn record(&self, lab: &Lab, cmd: vk::CommandBuffer, screen: &Screen) {
        use Access::*;
        let device = &lab.gpu().device;
        let vk::Extent2D { width, height } = self.image.extent;
        let groups = [width.div_ceil(8), height.div_ceil(8), 1];
        sync::discard(device, cmd, &self.image, LookupRead, ColorAttachment);
        sync::discard(device, cmd, &self.depth, DepthAttachment, DepthAttachment);
        let target = |image: &Image, image_layout, store_op| {
            vk::RenderingAttachmentInfo::default()
                .image_view(image.view)
                .image_layout(image_layout)
                .load_op(vk::AttachmentLoadOp::CLEAR)
                .store_op(store_op)
        };
        // clear values are all zero: depth 0 is the far end
        use vk::AttachmentStoreOp as S;
        let colors = [target(&self.image, vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL, S::STORE)];
        let depth = target(&self.depth, vk::ImageLayout::DEPTH_ATTACHMENT_OPTIMAL, S::DONT_CARE);
        let info = vk::RenderingInfo::default().color_attachments(&colors).depth_attachment(&depth);
        let seen = |alpha_tested| lab.draws().iter().filter(move |d| d.alpha_tested == alpha_tested);
        draw(lab, cmd, self.image.extent, info, &self.draws, seen);
        sync::image(device, cmd, &self.image, ColorAttachment, LookupRead);
        sync::image(device, cmd, &screen.receivers.depth, ComputeRead, StorageImage);
        self.snap.dispatch(cmd, &(), groups);
        sync::image(device, cmd, &screen.receivers.depth, StorageImage, ComputeRead);
    }
}

/// Draws with a pipeline for what is not alpha tested and one for what is.
pub(super) fn draw<'a, D: Iterator<Item = &'a MeshDraw>>(
    lab: &Lab,
    cmd: vk::CommandBuffer,
    extent: vk::Extent2D,
    info: vk::RenderingInfo<'_>,
    pipelines: &[Graphics; 2],
    draws: impl Fn(bool) -> D,
) {
    let device = &lab.gpu().device;
    let area = vk::Rect2D { offset: vk::Offset2D::default(), extent };
    // SAFETY: the command buffer is recording; buffers and images outlive the submission
    unsafe {
        device.cmd_begin_rendering(cmd, &info.render_area(area).layer_count(1));
        set_area(device, cmd, area);
        for (pipeline, alpha_tested) in pipelines.iter().zip([false, true]) {
            pipeline.bind(cmd);
            for d in draws(alpha_tested) {
                device.cmd_draw(cmd, d.index_count, d.instance_count, d.first_index, d.first_instance);
            }
        }
        device.cmd_end_rendering(cmd);
    }
}

/// Vertices are fetched by the shader, and nothing but buffers is written.
pub(super) fn bare(scene: &SceneBuffers) -> GraphicsState<'static> {
    GraphicsState { positions: None, depth: false, ..GraphicsState::casters(scene.position_layout, false) }
}
