//! Depth as other hosts have it: any format and projection, made from the lab's own.

use super::stages::write_image;
use super::{Lab, LabError};
use crate::engine::Engine;
use crate::gpu::sync::Access;
use crate::gpu::{Image, ImageSpec};
use crate::host::{FrameInput, HostImage, ImageUse, ReceiverImages, Receivers};
use crate::{Config, Error};
use ash::vk;
use glam::{DMat4, DVec4};

/// Visibility of every pixel towards the first light, where the depth image has `format` and was drawn with
/// `clip_from_view` (the lab's own but for the depth it gives). The view's first image is the lab's own, the frame names the second.
pub fn visibility(lab: &Lab, config: &Config, format: vk::Format, clip_from_view: DMat4) -> Result<Vec<f32>, LabError> {
    lab.run_prepass()?;
    let own: Vec<f32> = bytemuck::pod_collect_to_vec(&lab.read_image(&lab.prepass.depth, Access::ComputeRead, 4)?);
    let camera = lab.view.camera;
    let (near, far) = (camera.near, camera.far);
    let clip_at = |distance: f64| {
        let at = clip_from_view * DVec4::new(0.0, 0.0, -distance, 1.0);
        at.z / at.w
    };
    let nothing = if clip_at(near) < clip_at(2.0 * near) { 1.0 } else { 0.0 };
    let stored = own.iter().map(|&own| match own {
        0.0 => nothing,
        own => clip_at(near * far / (f64::from(own) * (far - near) + near)),
    });
    let bytes: Vec<u8> = match format {
        vk::Format::D16_UNORM => stored.flat_map(|s| ((s * 65535.0).round() as u16).to_le_bytes()).collect(),
        vk::Format::D32_SFLOAT | vk::Format::D32_SFLOAT_S8_UINT => {
            stored.flat_map(|s| (s as f32).to_le_bytes()).collect()
        }
        _ => stored.flat_map(|s| ((s * 16_777_215.0).round() as u32).to_le_bytes()).collect(),
    };
    let [width, height] = lab.view.size;
    use vk::ImageUsageFlags as I;
    let usage = I::DEPTH_STENCIL_ATTACHMENT | I::SAMPLED | I::TRANSFER_DST;
    let depth = Image::new(&lab.gpu, "depth of a host", &ImageSpec { format, width, height, layers: 0, usage })?;
    write_image(lab, &depth, &bytes)?;
    let first = lab.prepass.images();
    let images = [first, ReceiverImages { depth: HostImage::own(&depth, format), ..first }];
    let view = Receivers { size: lab.view.size, images: &images, mask: ImageUse::COPIED };
    let mut engine = Engine::on(&lab.gpu, config, &lab.buffers, &[view])?;
    engine.add_light(lab.light(0)?)?;
    let input = FrameInput { clip_from_view, images: 1, ..lab.frame_input() };
    let mut recorded = Err(Error::Unsupported { what: "a frame that was not recorded".into() });
    lab.submit(|cmd| recorded = engine.record_timed(cmd, &[input], None, None))?;
    recorded?;
    let mask = lab.read_image(&engine.views[0].buffers.mask, Access::TransferRead, 4)?;
    Ok(bytemuck::pod_collect_to_vec(&mask))
}
