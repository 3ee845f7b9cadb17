//! Which triangle each texel of a map sees: for `bias=ids` (Hourcade, Nicolas 1985; Fernando 2002, ch. 2), where a sample whose
//! triangle the map holds needs no comparison of depths, and for [`super::triangle_store`].

use super::MethodSpec;
use super::map::Shape;
use super::map_light::Kind;
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Graphics, GraphicsState, Image, ImageSpec, Shaders, set_area, spirv};
use crate::lab::{Lab, LabError};
use ash::vk;

/// Numbers are stored as floats, which are exact up to this.
const MOST: u64 = 1 << 24;

const FORMAT: vk::Format = vk::Format::R32G32_SFLOAT;

pub(super) struct PolygonIds {
    /// The instance and the scene's triangle + 1 of each texel's nearest; 0 and 0 where there is none.
    pub(super) map: Image,
    /// One for each layer.
    draws: Vec<Graphics>,
}

impl PolygonIds {
    /// `bindings`: those of the map's own draws.
    pub(super) fn new(
        spec: &MethodSpec,
        lab: &Lab,
        (shape, kind): (&Shape, Kind),
        bindings: &[Binding<'_>; 6],
    ) -> Result<Self, LabError> {
        use vk::ImageUsageFlags as I;
        let (gpu, scene) = (lab.gpu(), lab.scene_buffers());
        let triangles = lab.scene().indices.len() as u64 / 3;
        if triangles.max(scene.instance_count.into()) >= MOST {
            return Err(LabError::Refused(format!(
                "'{spec}': the scene has {triangles} triangles and {} instances, numbers of triangles allow {} of either",
                scene.instance_count,
                MOST - 1
            )));
        }
        let [width, height] = [shape.side; 2];
        let usage = I::COLOR_ATTACHMENT | I::SAMPLED | I::TRANSFER_SRC;
        let map = ImageSpec { format: FORMAT, width, height, layers: shape.layers, usage };
        // without attributes nothing is alpha tested
        let attributes = scene.attributes.unwrap_or(scene.positions);
        let fetched = [scene.positions, scene.indices, attributes].map(Binding::External);
        let state = GraphicsState {
            positions: None,
            colors: &[FORMAT],
            depth_compare: vk::CompareOp::GREATER_OR_EQUAL,
            ..GraphicsState::casters(scene.position_layout, false)
        };
        let [stride, offset, format] = scene.position_layout.words();
        let cull = shape.comparison.cull as u32;
        let draw = |layer: u32| {
            let constants = &[layer, u32::from(kind != Kind::Parallel), cull, 0, stride, offset, format];
            let (vertex, fragment) = (spirv!("methods/ids.vert"), spirv!("methods/ids.frag"));
            let shaders = Shaders { vertex, tessellation: None, fragment: Some(fragment), constants };
            Graphics::new(gpu, "ids", &shaders, &[&bindings[..], &fetched].concat(), &state)
        };
        Ok(Self {
            map: Image::new(gpu, "map of polygons", &map)?,
            draws: (0..shape.layers).map(draw).collect::<Result<_, _>>()?,
        })
    }

    /// What the last frame left in all layers: instance and triangle + 1 of each texel.
    pub(super) fn held(&self, lab: &Lab) -> Result<Vec<[u32; 2]>, LabError> {
        let held: Vec<[f32; 2]> = bytemuck::pod_collect_to_vec(&lab.read_image(&self.map, Access::LookupRead, 8)?);
        Ok(held.into_iter().map(|of| of.map(|v| v as u32)).collect())
    }

    /// Draws the map, depths into `map`; leaves both for lookups.
    pub(super) fn draw(&self, lab: &Lab, cmd: vk::CommandBuffer, map: &Image) {
        use Access::{ColorAttachment, DepthAttachment, LookupRead};
        let device = &lab.gpu().device;
        sync::discard(device, cmd, &self.map, LookupRead, ColorAttachment);
        sync::discard(device, cmd, map, LookupRead, DepthAttachment);
        let target = |image: &Image, layout| {
            vk::RenderingAttachmentInfo::default()
                .image_view(image.view)
                .image_layout(layout)
                .load_op(vk::AttachmentLoadOp::CLEAR)
                .store_op(vk::AttachmentStoreOp::STORE)
        };
        // clear values are all zero: no triangle, and the far end
        let colors = [target(&self.map, vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)];
        let depths = target(map, vk::ImageLayout::DEPTH_ATTACHMENT_OPTIMAL);
        let area = vk::Rect2D { offset: vk::Offset2D::default(), extent: map.extent };
        let info = vk::RenderingInfo::default()
            .render_area(area)
            .layer_count(self.draws.len() as u32)
            .color_attachments(&colors)
            .depth_attachment(&depths);
        // SAFETY: the command buffer is recording; buffers and images outlive the submission
        unsafe {
            device.cmd_begin_rendering(cmd, &info);
            set_area(device, cmd, area);
            for draw in &self.draws {
                draw.bind(cmd);
                for (d, _) in lab.draws().iter().zip(&lab.scene().meshes).filter(|(_, mesh)| mesh.casts) {
                    device.cmd_draw(cmd, d.index_count, d.instance_count, d.first_index, d.first_instance);
                }
            }
            device.cmd_end_rendering(cmd);
        }
        sync::image(device, cmd, &self.map, ColorAttachment, LookupRead);
        sync::image(device, cmd, map, DepthAttachment, LookupRead);
    }
}
