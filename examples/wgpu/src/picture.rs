//! What the renderer draws with wgpu: colour, depth and normals of the scene, then the picture with shadows.

use crate::device::Gpu;
use crate::{Result, SIZE};
use ash::vk;
use glam::{DMat4, DVec3, Mat4, Vec4};
use umbrage::scene::Scene;
use umbrage::{FrameInput, SceneBuffers};

const SHADER: &str = "
struct Push { clip_from_mesh: mat4x4f, rows: mat3x4f }
@group(0) @binding(0) var<storage, read> placed: array<Push>;
struct Corner { @builtin(position) clip: vec4f, @location(0) from_eye: vec3f }
@vertex fn place(@location(0) position: vec3f, @builtin(instance_index) i: u32) -> Corner {
    let p = vec4f(position, 1.0);
    return Corner(placed[i].clip_from_mesh * p, p * placed[i].rows);
}
struct Painted { @location(0) color: vec4f, @location(1) normal: u32 }
// as umbrage_normal.glsl
fn encode_normal(n: vec3f) -> u32 {
    let p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    let folded = (1.0 - abs(p.yx)) * select(vec2f(-1.0), vec2f(1.0), p >= vec2f(0.0));
    return pack2x16snorm(select(p, folded, n.z < 0.0));
}
@fragment fn paint(corner: Corner) -> Painted {
    var n = normalize(cross(dpdx(corner.from_eye), dpdy(corner.from_eye)));
    n = select(n, -n, dot(n, corner.from_eye) > 0.0);
    return Painted(vec4f(0.5 + 0.4 * n, 1.0), encode_normal(n));
}
@group(0) @binding(0) var color: texture_2d<f32>;
@group(0) @binding(1) var<storage, read> mask: array<f32>;
@group(0) @binding(2) var<storage, read_write> pixels: array<vec2u>;
@compute @workgroup_size(8, 8) fn shade(@builtin(global_invocation_id) pixel: vec3u) {
    let size = textureDimensions(color);
    if any(pixel.xy >= size) { return; }
    let at = pixel.y * size.x + pixel.x;
    let lit = textureLoad(color, pixel.xy, 0).rgb * mix(0.33, 1.0, mask[at]);
    pixels[at] = vec2u(pack4x8unorm(vec4f(lit, 1.0)), bitcast<u32>(mask[at]));
}";

pub struct Renderer {
    pub depth: wgpu::Texture,
    pub depth_view: wgpu::TextureView,
    pub normal: wgpu::Texture,
    pub normal_view: wgpu::TextureView,
    /// A float for each pixel, where Umbrage's mask goes.
    pub mask: vk::Buffer,
    color: wgpu::TextureView,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    pixels: wgpu::Buffer,
    read: wgpu::Buffer,
    draw: wgpu::RenderPipeline,
    shade: wgpu::ComputePipeline,
    placed: wgpu::BindGroup,
    shaded: wgpu::BindGroup,
    /// First index, number of indices and instance.
    draws: Vec<[u32; 3]>,
}

impl Renderer {
    pub fn new(gpu: &Gpu, scene: &Scene, buffers: &SceneBuffers, input: &FrameInput) -> Result<Self> {
        use wgpu::{BufferUsages as B, TextureUsages as T};
        let device = &gpu.device;
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(SHADER.into()),
        });
        let texture = |format, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d { width: SIZE[0], height: SIZE[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let depth = texture(wgpu::TextureFormat::Depth32Float, T::RENDER_ATTACHMENT | T::TEXTURE_BINDING);
        let depth_view = depth.create_view(&wgpu::TextureViewDescriptor::default());
        let color = texture(wgpu::TextureFormat::Rgba8Unorm, T::RENDER_ATTACHMENT | T::TEXTURE_BINDING);
        let color = color.create_view(&wgpu::TextureViewDescriptor::default());
        let normal = texture(wgpu::TextureFormat::R32Uint, T::RENDER_ATTACHMENT | T::TEXTURE_BINDING);
        let normal_view = normal.create_view(&wgpu::TextureViewDescriptor::default());

        // wgpu's clip space has y up, Vulkan's and Umbrage's y down
        let clip = DMat4::from_scale(DVec3::new(1.0, -1.0, 1.0))
            * input.clip_from_view
            * DMat4::from_mat3(input.view_from_world);
        let place = |instance: &umbrage::Instance| {
            let offset = instance.translation() + input.origin - input.eye;
            let column = |i: usize| DVec3::from_array([0, 1, 2].map(|r| f64::from(instance.rows[r][i])));
            let matrix = DMat4::from_cols(
                column(0).extend(0.0),
                column(1).extend(0.0),
                column(2).extend(0.0),
                offset.extend(1.0),
            );
            let rows = [0, 1, 2].map(|i| Vec4::from_array(instance.rows[i]).truncate().extend(offset[i] as f32));
            ((clip * matrix).as_mat4(), rows)
        };
        let placed: Vec<u8> = scene
            .instances
            .iter()
            .flat_map(|instance| {
                let (clip, rows): (Mat4, [Vec4; 3]) = place(instance);
                [bytemuck::bytes_of(&clip), bytemuck::bytes_of(&rows)].concat()
            })
            .collect();
        let buffer = |bytes: &[u8], usage, lent| -> Result<(vk::Buffer, wgpu::Buffer)> {
            let raw = gpu.buffer(bytes, usage)?;
            Ok((raw, gpu.lend(raw, bytes.len() as u64, lent)))
        };
        use vk::BufferUsageFlags as U;
        let (_, placed) = buffer(&placed, U::STORAGE_BUFFER, B::STORAGE)?;
        let count = (SIZE[0] * SIZE[1]) as usize;
        let (mask, mask_lent) = buffer(&vec![0; 4 * count], U::STORAGE_BUFFER | U::TRANSFER_DST, B::STORAGE)?;
        let own = |usage| {
            let descriptor =
                wgpu::BufferDescriptor { label: None, size: 8 * count as u64, usage, mapped_at_creation: false };
            device.create_buffer(&descriptor)
        };
        let (pixels, read) = (own(B::STORAGE | B::COPY_SRC), own(B::MAP_READ | B::COPY_DST));

        let draw = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("scene"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("place"),
                compilation_options: Default::default(),
                buffers: &[wgpu::VertexBufferLayout {
                    array_stride: 12,
                    step_mode: wgpu::VertexStepMode::Vertex,
                    attributes: &wgpu::vertex_attr_array![0 => Float32x3],
                }],
            },
            primitive: wgpu::PrimitiveState::default(),
            // reversed depth: nearer is greater
            depth_stencil: Some(wgpu::DepthStencilState {
                format: wgpu::TextureFormat::Depth32Float,
                depth_write_enabled: true,
                depth_compare: wgpu::CompareFunction::GreaterEqual,
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("paint"),
                compilation_options: Default::default(),
                targets: &[Some(wgpu::TextureFormat::Rgba8Unorm.into()), Some(wgpu::TextureFormat::R32Uint.into())],
            }),
            multiview: None,
            cache: None,
        });
        let shade = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("shade"),
            layout: None,
            module: &module,
            entry_point: Some("shade"),
            compilation_options: Default::default(),
            cache: None,
        });
        let group = |layout: &wgpu::BindGroupLayout, resources: &[wgpu::BindingResource<'_>]| {
            let entries: Vec<_> = (0..)
                .zip(resources)
                .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource: resource.clone() })
                .collect();
            device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
        };
        let shaded =
            [wgpu::BindingResource::TextureView(&color), mask_lent.as_entire_binding(), pixels.as_entire_binding()];
        Ok(Self {
            placed: group(&draw.get_bind_group_layout(0), &[placed.as_entire_binding()]),
            shaded: group(&shade.get_bind_group_layout(0), &shaded),
            vertices: gpu.lend(buffers.positions, 12 * scene.positions.len() as u64, B::VERTEX),
            indices: gpu.lend(buffers.indices, 4 * u64::from(buffers.index_count), B::INDEX),
            draws: (0..)
                .zip(&scene.instances)
                .map(|(i, instance)| {
                    let mesh = scene.meshes[instance.mesh as usize];
                    [mesh.first_index, mesh.index_count, i]
                })
                .collect(),
            depth,
            depth_view,
            normal,
            normal_view,
            mask,
            color,
            pixels,
            read,
            draw,
            shade,
        })
    }

    /// The pass before Umbrage.
    pub fn draw(&self, gpu: &Gpu) -> wgpu::CommandBuffer {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        {
            let target = |view| {
                let ops = wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                };
                Some(wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops })
            };
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("scene"),
                color_attachments: &[target(&self.color), target(&self.normal_view)],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &self.depth_view,
                    depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Store }),
                    stencil_ops: None,
                }),
                timestamp_writes: None,
                occlusion_query_set: None,
            });
            pass.set_pipeline(&self.draw);
            pass.set_bind_group(0, &self.placed, &[]);
            pass.set_vertex_buffer(0, self.vertices.slice(..));
            pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
            for &[first, count, instance] in &self.draws {
                pass.draw_indexed(first..first + count, 0, instance..instance + 1);
            }
        }
        encoder.finish()
    }

    /// The pass after it.
    pub fn shade(&self, gpu: &Gpu) -> wgpu::CommandBuffer {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&self.shade);
            pass.set_bind_group(0, &self.shaded, &[]);
            pass.dispatch_workgroups(SIZE[0].div_ceil(8), SIZE[1].div_ceil(8), 1);
        }
        encoder.copy_buffer_to_buffer(&self.pixels, 0, &self.read, 0, self.read.size());
        encoder.finish()
    }

    /// The last picture, and the mask it was shaded with.
    pub fn read(&self, gpu: &Gpu) -> Result<(Vec<u32>, Vec<f32>)> {
        self.read.slice(..).map_async(wgpu::MapMode::Read, |_| ());
        gpu.wait()?;
        let words: Vec<[u32; 2]> = bytemuck::pod_collect_to_vec(&self.read.slice(..).get_mapped_range());
        Ok((words.iter().map(|w| w[0]).collect(), words.iter().map(|w| f32::from_bits(w[1])).collect()))
    }
}
