//! Which triangle each texel of a map and each pixel of the image sees, for `bias=ids` (Hourcade, Nicolas 1985; Fernando 2002,
//! ch. 2): a sample whose triangle the map holds needs no comparison of depths.

use super::MethodSpec;
use super::map::Shape;
use super::map_light::Kind;
use crate::engine::depth_prepass::MeshDraw;
use crate::gpu::sync::{self, Access};
use crate::gpu::{Binding, Buffer, Graphics, GraphicsState, Image, ImageSpec, Memory, Shaders, set_area, spirv};
use crate::lab::{Lab, LabError};
use ash::vk;

/// Numbers are stored as floats, which are exact up to this.
const MOST: u64 = 1 << 24;

pub(super) struct PolygonIds {
    /// The number of each texel's nearest triangle, 0 where there is none.
    pub(super) map: Image,
    /// The same of each pixel.
    pub(super) view: Image,
    view_depth: Image,
    bases: Buffer,
    /// One for each layer.
    to_map: Vec<Graphics>,
    to_view: Graphics,
}

impl PolygonIds {
    /// `bindings`: those of the map's own draws; `frame`: the camera's constants.
    pub(super) fn new(
        spec: &MethodSpec,
        lab: &Lab,
        (shape, kind): (&Shape, Kind),
        bindings: &[Binding<'_>; 6],
        frame: &Buffer,
    ) -> Result<Self, LabError> {
        use vk::{Format as F, ImageUsageFlags as I};
        let (gpu, scene) = (lab.gpu(), lab.scene_buffers());
        if shape.tiled {
            return Err(LabError::Refused(format!("'{spec}': bias=ids does not serve maps of tiles")));
        }
        let bases = bases(spec, lab)?;
        let color = |name, [width, height]: [u32; 2], layers| {
            let usage = I::COLOR_ATTACHMENT | I::SAMPLED;
            Image::new(gpu, name, &ImageSpec { format: F::R32_SFLOAT, width, height, layers, usage })
        };
        let [width, height] = lab.view().size;
        let usage = I::DEPTH_STENCIL_ATTACHMENT | I::SAMPLED;
        let depth = ImageSpec { format: F::D32_SFLOAT, width, height, layers: 0, usage };
        let fetched = [
            Binding::External(scene.positions),
            Binding::External(scene.indices),
            // without attributes nothing is alpha tested
            Binding::External(scene.attributes.unwrap_or(scene.positions)),
            Binding::Storage(&bases),
        ];
        let state = GraphicsState {
            positions: None,
            colors: &[F::R32_SFLOAT],
            depth_compare: vk::CompareOp::GREATER_OR_EQUAL,
            ..GraphicsState::casters(scene.position_layout, false)
        };
        let [stride, offset, format] = scene.position_layout.words();
        let pipeline = |name, vertex: &[u8], constants: [u32; 4], first: Binding<'_>| {
            let constants = [&constants[..], &[stride, offset, format]].concat();
            let shaders = Shaders { vertex, fragment: Some(spirv!("methods/ids.frag")), constants: &constants };
            Graphics::new(gpu, name, &shaders, &[&[first], &bindings[1..], &fetched].concat(), &state)
        };
        let cull = shape.comparison.cull as u32;
        let (to_map, to_view) = (spirv!("methods/ids_map.vert"), spirv!("methods/ids_view.vert"));
        let layer = |l| pipeline("ids_map", to_map, [l, u32::from(kind != Kind::Parallel), cull, 0], bindings[0]);
        Ok(Self {
            map: color("map of polygons", [shape.side; 2], shape.layers)?,
            view: color("polygons of pixels", [width, height], 0)?,
            view_depth: Image::new(gpu, "depth of polygons", &depth)?,
            to_map: (0..shape.layers).map(layer).collect::<Result<_, _>>()?,
            to_view: pipeline("ids_view", to_view, [0; 4], Binding::Uniform(frame))?,
            bases,
        })
    }

    /// Draws the map, depths into `map`, and the image; leaves all for lookups.
    pub(super) fn draw(&self, lab: &Lab, cmd: vk::CommandBuffer, map: &Image) {
        let casters = || lab.draws().iter().zip(&lab.scene().meshes).filter(|(_, mesh)| mesh.casts).map(|(d, _)| d);
        draw_into(lab, cmd, (&self.map, map), &self.to_map, casters);
        draw_into(lab, cmd, (&self.view, &self.view_depth), std::slice::from_ref(&self.to_view), || lab.draws().iter());
    }

    pub(super) fn bytes(&self) -> u64 {
        self.map.bytes + self.view.bytes + self.view_depth.bytes + self.bases.size
    }
}

/// The number of each instance's first triangle, counted from 1, less the first triangle of its mesh.
fn bases(spec: &MethodSpec, lab: &Lab) -> Result<Buffer, LabError> {
    let mut words = vec![0u32; lab.scene_buffers().instance_count as usize];
    let mut next = 1u64;
    for d in lab.draws() {
        for i in d.first_instance..d.first_instance + d.instance_count {
            words[i as usize] = (next as u32).wrapping_sub(d.first_index / 3);
            next += u64::from(d.index_count / 3);
        }
    }
    if next > MOST {
        return Err(LabError::Refused(format!(
            "'{spec}': the scene has {} triangles, bias=ids allows {}",
            next - 1,
            MOST - 1
        )));
    }
    let bytes = 4 * words.len().max(1) as u64;
    let mut buffer =
        Buffer::new(lab.gpu(), "polygon bases", bytes, vk::BufferUsageFlags::STORAGE_BUFFER, Memory::Upload)?;
    buffer.bytes_mut()[..4 * words.len()].copy_from_slice(bytemuck::cast_slice(&words));
    Ok(buffer)
}

/// Every pipeline draws all of `meshes`.
fn draw_into<'a, D: Iterator<Item = &'a MeshDraw>>(
    lab: &Lab,
    cmd: vk::CommandBuffer,
    (color, depth): (&Image, &Image),
    pipelines: &[Graphics],
    meshes: impl Fn() -> D,
) {
    use Access::{ColorAttachment, DepthAttachment, LookupRead};
    let device = &lab.gpu().device;
    sync::discard(device, cmd, color, LookupRead, ColorAttachment);
    sync::discard(device, cmd, depth, LookupRead, DepthAttachment);
    let target = |image: &Image, layout| {
        vk::RenderingAttachmentInfo::default()
            .image_view(image.view)
            .image_layout(layout)
            .load_op(vk::AttachmentLoadOp::CLEAR)
            .store_op(vk::AttachmentStoreOp::STORE)
    };
    // clear values are all zero: no triangle, and the far end
    let colors = [target(color, vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)];
    let depths = target(depth, vk::ImageLayout::DEPTH_ATTACHMENT_OPTIMAL);
    let area = vk::Rect2D { offset: vk::Offset2D::default(), extent: color.extent };
    let info = vk::RenderingInfo::default()
        .render_area(area)
        .layer_count(pipelines.len() as u32)
        .color_attachments(&colors)
        .depth_attachment(&depths);
    // SAFETY: the command buffer is recording; buffers and images outlive the submission
    unsafe {
        device.cmd_begin_rendering(cmd, &info);
        set_area(device, cmd, area);
        for pipeline in pipelines {
            pipeline.bind(cmd);
            for d in meshes() {
                device.cmd_draw(cmd, d.index_count, d.instance_count, d.first_index, d.first_instance);
            }
        }
        device.cmd_end_rendering(cmd);
    }
    sync::image(device, cmd, color, ColorAttachment, LookupRead);
    sync::image(device, cmd, depth, DepthAttachment, LookupRead);
}
