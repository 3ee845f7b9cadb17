//! Draws the casters of every page into its layer of the atlas: a clear of the pages that are drawn, then one indirect
//! draw for opaque and one for alpha-tested casters; between these what the host draws itself. For large filters, the
//! depth range of every layer drawn.
//! Reads: draw commands, pairs, pages. Writes: atlas, depth ranges. No capacity of its own.

use super::buffers::{Buffers, arguments};
use crate::gpu::structs::COMMAND_BYTES;
use crate::gpu::{Binding, Buffer, Compute, Gpu, Graphics, GraphicsState, HostSet, Shaders, set_area, spirv};
use crate::host::SceneBuffers;
use crate::{Config, Cull, Error};
use ash::vk;
use std::mem::offset_of;
use std::sync::Arc;

pub(crate) struct Tiles {
    clear: Graphics,
    opaque: Graphics,
    masked: Graphics,
    /// Where the lookup asks for them.
    ranges: Option<Compute>,
    /// Where the host draws casters.
    host_set: Option<HostSet>,
    scene: SceneBuffers,
    cull: Cull,
    pair_capacity: u32,
    gpu: Arc<Gpu>,
}

impl Tiles {
    pub(crate) fn new(gpu: &Arc<Gpu>, config: &Config, b: &Buffers, scene: &SceneBuffers) -> Result<Self, Error> {
        let constants = [config.page_texels, config.gutter, config.cull as u32];
        let bindings = [
            Binding::Storage(&b.lights),
            Binding::Storage(&b.pages),
            Binding::Storage(&b.pairs),
            Binding::External(scene.instances),
            Binding::External(scene.materials),
            Binding::External(scene.texels),
        ];
        // the nearest caster has the greatest depth
        let state = |attributes| GraphicsState {
            depth_compare: vk::CompareOp::GREATER_OR_EQUAL,
            ..GraphicsState::casters(scene.position_layout, attributes)
        };
        let clear = GraphicsState { positions: None, depth_compare: vk::CompareOp::ALWAYS, ..state(false) };
        Ok(Self {
            clear: Graphics::new(
                gpu,
                "tiles_clear",
                &Shaders {
                    vertex: spirv!("engine/tiles_clear.vert"),
                    tessellation: None,
                    fragment: None,
                    constants: &[],
                },
                &[Binding::Storage(&b.cleared)],
                &clear,
            )?,
            opaque: Graphics::new(
                gpu,
                "tiles",
                &Shaders {
                    vertex: spirv!("engine/tiles.vert"),
                    tessellation: None,
                    fragment: None,
                    constants: &constants,
                },
                &bindings[..4],
                &state(false),
            )?,
            masked: Graphics::new(
                gpu,
                "tiles_masked",
                &Shaders {
                    vertex: spirv!("engine/tiles_masked.vert"),
                    tessellation: None,
                    fragment: Some(spirv!("engine/tiles_masked.frag")),
                    constants: &constants,
                },
                &bindings,
                &state(true),
            )?,
            ranges: config
                .filter
                .ranged()
                .then(|| {
                    let words = spirv!("engine/tiles_ranges.comp");
                    let bindings =
                        [Binding::Sampled(&b.atlas), Binding::Storage(&b.cleared), Binding::Storage(&b.ranges)];
                    Compute::new(gpu, "tiles_ranges", words, &bindings, &constants[..1], 0)
                })
                .transpose()?,
            host_set: b.host_pairs.as_ref().map(|pairs| Self::host(gpu, b, pairs, scene)).transpose()?,
            scene: *scene,
            cull: config.cull,
            pair_capacity: config.pair_capacity,
            gpu: gpu.clone(),
        })
    }

    /// What `glsl/host/umbrage_caster.glsl` reads, for shaders of the host.
    fn host(gpu: &Arc<Gpu>, b: &Buffers, pairs: &Buffer, scene: &SceneBuffers) -> Result<HostSet, Error> {
        let [lights, pages, pairs] = [&b.lights, &b.pages, pairs].map(Binding::Storage);
        let bindings = [b.frame(0), lights, pages, pairs, Binding::External(scene.instances)];
        HostSet::new(gpu, "host casters", vk::ShaderStageFlags::ALL_GRAPHICS, &bindings)
    }

    pub(crate) fn host_set(&self) -> Option<(vk::DescriptorSetLayout, vk::DescriptorSet)> {
        self.host_set.as_ref().map(HostSet::handles)
    }

    /// `draw`: records the casters that the host draws.
    pub(crate) fn record(&self, cmd: vk::CommandBuffer, b: &Buffers, draw: Option<&mut dyn FnMut(vk::CommandBuffer)>) {
        let device = &self.gpu.device;
        let attachment = vk::RenderingAttachmentInfo::default()
            .image_view(b.atlas.view)
            .image_layout(vk::ImageLayout::DEPTH_ATTACHMENT_OPTIMAL)
            .load_op(vk::AttachmentLoadOp::LOAD)
            .store_op(vk::AttachmentStoreOp::STORE);
        let area = vk::Rect2D { offset: vk::Offset2D::default(), extent: b.atlas.extent };
        let info =
            vk::RenderingInfo::default().render_area(area).layer_count(b.atlas.layers).depth_attachment(&attachment);
        // SAFETY: the command buffer is recording; buffers and images outlive the submission
        unsafe {
            device.cmd_begin_rendering(cmd, &info);
            set_area(device, cmd, area);
            self.clear.bind(cmd);
            device.cmd_draw_indirect(cmd, b.arguments.raw, 4 * u64::from(arguments::CLEAR), 1, 0);
            // before the engine's own: where a draw had its count in a buffer, lavapipe (22.3, 25.0) holds later indirect
            // draws of the command buffer to that count
            if let (Some(draw), Some(_)) = (draw, &self.host_set) {
                draw(cmd);
                set_area(device, cmd, area);
            }
            device.cmd_bind_index_buffer(cmd, self.scene.indices, 0, vk::IndexType::UINT32);
            device.cmd_bind_vertex_buffers(cmd, 0, &self.scene.vertices(), &[0, 0]);
        }
        // sides are told apart in the fragment shader, since mirrored instances turn the winding over
        if self.cull == Cull::None {
            self.opaque.bind(cmd)
        } else {
            self.masked.bind(cmd)
        }
        self.draw(cmd, b, false);
        if self.scene.alpha_tested {
            self.masked.bind(cmd);
            self.draw(cmd, b, true);
        }
        // SAFETY: rendering was begun above
        unsafe { device.cmd_end_rendering(cmd) };
    }

    /// Depth ranges of what was drawn; whether there is anything to wait for.
    pub(crate) fn record_ranges(&self, cmd: vk::CommandBuffer, b: &Buffers) -> bool {
        if let Some(ranges) = &self.ranges {
            ranges.dispatch_indirect(cmd, &(), &b.arguments, 4 * u64::from(arguments::RANGES));
        }
        self.ranges.is_some()
    }

    fn draw(&self, cmd: vk::CommandBuffer, b: &Buffers, masked: bool) {
        use crate::gpu::structs::Counters;
        let device = &self.gpu.device;
        let offset = if masked { u64::from(self.pair_capacity) * COMMAND_BYTES } else { 0 };
        let count = if masked { offset_of!(Counters, pairs_masked) } else { offset_of!(Counters, pairs_opaque) };
        let stride = COMMAND_BYTES as u32;
        // SAFETY: pipeline, set and vertex buffers are bound; commands and counters have indirect usage
        unsafe {
            if self.gpu.draw_indirect_count {
                device.cmd_draw_indexed_indirect_count(
                    cmd,
                    b.commands.raw,
                    offset,
                    b.counters.raw,
                    count as u64,
                    self.pair_capacity,
                    stride,
                );
            } else {
                // commands beyond the count were filled with zeros and draw nothing
                device.cmd_draw_indexed_indirect(cmd, b.commands.raw, offset, self.pair_capacity, stride);
            }
        }
    }
}
