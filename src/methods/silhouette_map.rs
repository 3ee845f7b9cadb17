//! The silhouette map of one light: which edges are silhouettes, and the point that each texel holds.

use super::DebugPicture;
use super::silhouette_edges::Edges;
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Buffer, Compute, Graphics, GraphicsState, Image, ImageSpec, Shaders, set_area, spirv};
use crate::lab::{Lab, LabError};
use crate::output::Picture;
use ash::vk;

/// Float16 is exact enough for a texel's inside, and every device can draw into it.
const FORMAT: vk::Format = vk::Format::R16G16_SFLOAT;
/// The point of a texel that no silhouette passes: its middle, as if there were no silhouette map (source, 2).
const MIDDLE: [f32; 4] = [0.5, 0.5, 0.0, 0.0];
const EMPTY: [u8; 3] = [24, 24, 28];
const POINT: [u8; 3] = [255, 60, 40];
/// Most texels along a side of the debug picture, pixels along its side unless texels would be smaller than the last.
const SHOWN: u32 = 512;
const PICTURE: u32 = 1024;
const LEAST_TEXEL: u32 = 4;

pub(super) struct SilhouetteMap {
    list: Buffer,
    select: Compute,
    groups: [u32; 3],
    points: Image,
    /// Decides between edges that pass the same texel.
    winners: Image,
    /// For each layer.
    draws: Vec<Graphics>,
    device: ash::Device,
}

impl SilhouetteMap {
    /// `light`, `fits` and `map`: those of the conventional map; `position`: whether the light has one.
    pub(super) fn new(
        lab: &Lab,
        edges: &Edges,
        (light, fits, map): (&Buffer, &Buffer, &Image),
        position: u32,
    ) -> Result<Self, LabError> {
        use vk::ImageUsageFlags as I;
        let gpu = lab.gpu();
        let image = |name, format, usage| {
            let vk::Extent2D { width, height } = map.extent;
            Image::new(gpu, name, &ImageSpec { format, width, height, layers: map.layers, usage })
        };
        let list = edges.list(gpu)?;
        let select = edges.select(gpu, light, &list, position)?;
        let own = [Binding::Uniform(light), Binding::Storage(fits), Binding::Sampled(map)];
        let bindings = [&own[..], &edges.bindings(&list)].concat();
        let state = GraphicsState {
            positions: None,
            attributes: false,
            colors: &[FORMAT],
            depth_compare: vk::CompareOp::GREATER_OR_EQUAL,
            cull: vk::CullModeFlags::NONE,
        };
        let draw = |layer: u32| {
            let (vertex, fragment) = (spirv!("methods/silhouette_draw.vert"), spirv!("methods/silhouette_draw.frag"));
            let [stride, offset, format] = edges.position_words();
            let constants = [layer, position, edges.number_bits(), stride, offset, format];
            let shaders = Shaders { vertex, fragment: Some(fragment), constants: &constants };
            Graphics::new(gpu, "silhouette_draw", &shaders, &bindings, &state)
        };
        Ok(Self {
            select,
            groups: edges.groups(),
            points: image("silhouette points", FORMAT, I::COLOR_ATTACHMENT | I::SAMPLED | I::TRANSFER_SRC)?,
            winners: image(
                "silhouette winners",
                vk::Format::D32_SFLOAT,
                I::DEPTH_STENCIL_ATTACHMENT | I::TRANSFER_SRC,
            )?,
            draws: (0..map.layers).map(draw).collect::<Result<_, _>>()?,
            list,
            device: gpu.device.clone(),
        })
    }

    pub(super) fn points(&self) -> &Image {
        &self.points
    }

    pub(super) fn bytes(&self) -> u64 {
        self.points.bytes + self.winners.bytes + self.list.size
    }

    /// An empty list; the caller orders what comes before and after.
    pub(super) fn reset(&self, cmd: vk::CommandBuffer) {
        sync::barrier(&self.device, cmd, &[(Access::IndirectRead, Access::TransferWrite)]);
        let draw = [0u32, 1, 0, 0];
        // SAFETY: the command buffer is recording; the list begins with a draw
        unsafe { self.device.cmd_update_buffer(cmd, self.list.raw, 0, bytemuck::cast_slice(&draw)) };
    }

    /// Finds and draws; the conventional map must be readable by shaders, and the points are left so.
    pub(super) fn record(&self, cmd: vk::CommandBuffer) {
        use Access::*;
        let device = &self.device;
        self.select.dispatch(cmd, &(), self.groups);
        sync::barrier(device, cmd, &[(ComputeWrite, IndirectRead), (ComputeWrite, GraphicsRead)]);
        sync::discard(device, cmd, &self.points, ComputeRead, ColorAttachment);
        sync::discard(device, cmd, &self.winners, DepthAttachment, DepthAttachment);
        let target = |image: &Image, layout, clear_value| {
            vk::RenderingAttachmentInfo::default()
                .image_view(image.view)
                .image_layout(layout)
                .load_op(vk::AttachmentLoadOp::CLEAR)
                .store_op(vk::AttachmentStoreOp::STORE)
                .clear_value(clear_value)
        };
        let middle = vk::ClearValue { color: vk::ClearColorValue { float32: MIDDLE } };
        let colors = [target(&self.points, vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL, middle)];
        // clear values are all zero: any edge wins
        let depth = target(&self.winners, vk::ImageLayout::DEPTH_ATTACHMENT_OPTIMAL, vk::ClearValue::default());
        let area = vk::Rect2D { offset: vk::Offset2D::default(), extent: self.points.extent };
        let info = vk::RenderingInfo::default()
            .render_area(area)
            .layer_count(self.points.layers)
            .color_attachments(&colors)
            .depth_attachment(&depth);
        // SAFETY: the command buffer is recording; buffers and images outlive the submission
        unsafe {
            device.cmd_begin_rendering(cmd, &info);
            set_area(device, cmd, area);
            for draw in &self.draws {
                draw.bind(cmd);
                device.cmd_draw_indirect(cmd, self.list.raw, 0, 1, 0);
            }
            device.cmd_end_rendering(cmd);
        }
        sync::image(device, cmd, &self.points, ColorAttachment, ComputeRead);
    }

    /// Numbers of the edges that the last frame found, ascending.
    pub(super) fn found(&self, lab: &Lab) -> Result<Vec<u32>, LabError> {
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(&lab.read_buffer(&self.list)?);
        let mut found = words[4..][..(words[0] / 6) as usize].to_vec();
        found.sort_unstable();
        Ok(found)
    }

    /// Points and the keys of their edges, 0 where a texel holds none; all layers.
    pub(super) fn held(&self, lab: &Lab) -> Result<Vec<Option<[f32; 2]>>, LabError> {
        let points: Vec<[u16; 2]> =
            bytemuck::pod_collect_to_vec(&lab.read_image(&self.points, Access::ComputeRead, 4)?);
        let won: Vec<u32> = bytemuck::pod_collect_to_vec(&lab.read_image(&self.winners, Access::DepthAttachment, 4)?);
        // points are from 2^-10 to 1: neither signs nor denormals
        let float = |half: u16| f32::from_bits((u32::from(half) << 13) + (112 << 23));
        let held = |(point, won): ([u16; 2], u32)| (won != 0).then(|| point.map(float));
        Ok(points.into_iter().zip(won).map(held).collect())
    }

    /// The first layer of the depth map with points in their places; of a large map the middle.
    pub(super) fn picture(&self, lab: &Lab, map: &Image) -> Result<DebugPicture, LabError> {
        let depths: Vec<f32> = bytemuck::pod_collect_to_vec(&lab.read_image(map, Access::LookupRead, 4)?);
        let held = self.held(lab)?;
        let side = map.extent.width;
        let shown = side.min(SHOWN);
        let first = (side - shown) / 2;
        let texels = || (0..shown * shown).map(|i| (i % shown, i / shown));
        let at = |(x, y): (u32, u32)| ((first + y) * side + first + x) as usize;
        let drawn = || texels().map(|t| depths[at(t)]).filter(|d| *d > 0.0);
        let (low, high) = (drawn().fold(f32::INFINITY, f32::min), drawn().fold(0.0, f32::max));
        let texel = (PICTURE / shown).max(LEAST_TEXEL);
        let mut picture = Picture::filled(shown * texel, shown * texel, EMPTY);
        for t in texels().filter(|&t| depths[at(t)] > 0.0) {
            let grey = (64.0 + 160.0 * (depths[at(t)] - low) / (high - low).max(1e-9)) as u8;
            picture.fill(t.0 * texel, t.1 * texel, texel, texel, [grey; 3]);
        }
        let dot = texel.div_ceil(5);
        for (t, [u, v]) in texels().filter_map(|t| Some((t, held[at(t)]?))) {
            // the silhouette map's texels begin in the middle of the depth map's
            let place = |t: u32, within: f32| ((t as f32 + 0.5 + within) * texel as f32) as u32 - dot / 2;
            picture.fill(place(t.0, u), place(t.1, v), dot, dot, POINT);
        }
        Ok(DebugPicture { name: "silhouettes", width: picture.width, height: picture.height, rgb: picture.rgb })
    }
}
