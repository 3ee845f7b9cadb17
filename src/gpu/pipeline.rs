//! Pipelines with their descriptor set: bindings are given once, in binding order, when the pipeline is made.

use super::{Buffer, Gpu, Image, Structure, sync};
use crate::error::{Context, Error};
use crate::host::PositionLayout;
use ash::vk;
use bytemuck::Pod;
use std::ffi::CString;
use std::sync::Arc;

/// A resource at its place in the binding order.
#[derive(Clone, Copy)]
pub(crate) enum Binding<'a> {
    Uniform(&'a Buffer),
    Storage(&'a Buffer),
    /// A storage buffer that somebody else owns.
    External(vk::Buffer),
    StorageImage(&'a Image),
    /// Sampled by `texelFetch`; the sampler is a nearest one.
    Sampled(&'a Image),
    /// The same for an image that somebody else owns, in its layout.
    SampledView(vk::ImageView, vk::ImageLayout),
    /// What ray queries go through.
    Structure(&'a Structure),
}

impl Binding<'_> {
    fn kind(&self) -> vk::DescriptorType {
        match self {
            Binding::Uniform(_) => vk::DescriptorType::UNIFORM_BUFFER,
            Binding::Storage(_) | Binding::External(_) => vk::DescriptorType::STORAGE_BUFFER,
            Binding::StorageImage(_) => vk::DescriptorType::STORAGE_IMAGE,
            Binding::Sampled(_) | Binding::SampledView(..) => vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
            Binding::Structure(_) => vk::DescriptorType::ACCELERATION_STRUCTURE_KHR,
        }
    }
}

/// Layout, set and everything else that compute and graphics pipelines share.
struct Layout {
    name: &'static str,
    /// The same, for debuggers.
    label: CString,
    layout: vk::PipelineLayout,
    set_layout: vk::DescriptorSetLayout,
    pool: vk::DescriptorPool,
    set: vk::DescriptorSet,
    sampler: vk::Sampler,
    stages: vk::ShaderStageFlags,
    push_size: u32,
    gpu: Arc<Gpu>,
}

impl Layout {
    fn new(
        gpu: &Arc<Gpu>,
        name: &'static str,
        stages: vk::ShaderStageFlags,
        bindings: &[Binding<'_>],
        push_size: u32,
    ) -> Result<Self, Error> {
        let mut this = Self {
            name,
            label: CString::new(name).unwrap_or_default(),
            layout: vk::PipelineLayout::null(),
            set_layout: vk::DescriptorSetLayout::null(),
            pool: vk::DescriptorPool::null(),
            set: vk::DescriptorSet::null(),
            sampler: vk::Sampler::null(),
            stages,
            push_size,
            gpu: gpu.clone(),
        };
        let device = &gpu.device;
        let slots: Vec<_> = bindings
            .iter()
            .enumerate()
            .map(|(i, b)| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(i as u32)
                    .descriptor_type(b.kind())
                    .descriptor_count(1)
                    .stage_flags(stages)
            })
            .collect();
        let sizes: Vec<_> =
            bindings.iter().map(|b| vk::DescriptorPoolSize { ty: b.kind(), descriptor_count: 1 }).collect();
        // SAFETY: plain create calls with complete infos; `Drop` frees what was made when a later one fails
        unsafe {
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&slots);
            this.set_layout =
                device.create_descriptor_set_layout(&info, None).context("vkCreateDescriptorSetLayout")?;
            let set_layouts = [this.set_layout];
            let ranges = [vk::PushConstantRange { stage_flags: stages, offset: 0, size: push_size }];
            let mut info = vk::PipelineLayoutCreateInfo::default().set_layouts(&set_layouts);
            if push_size > 0 {
                info = info.push_constant_ranges(&ranges);
            }
            this.layout = device.create_pipeline_layout(&info, None).context("vkCreatePipelineLayout")?;
            this.sampler = device.create_sampler(&vk::SamplerCreateInfo::default(), None).context("vkCreateSampler")?;
            if !bindings.is_empty() {
                let info = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
                this.pool = device.create_descriptor_pool(&info, None).context("vkCreateDescriptorPool")?;
                let info =
                    vk::DescriptorSetAllocateInfo::default().descriptor_pool(this.pool).set_layouts(&set_layouts);
                this.set = device.allocate_descriptor_sets(&info).context("vkAllocateDescriptorSets")?[0];
            }
        }
        this.write(bindings);
        Ok(this)
    }

    fn write(&self, bindings: &[Binding<'_>]) {
        for (i, binding) in bindings.iter().enumerate() {
            let whole = |buffer| [vk::DescriptorBufferInfo { buffer, offset: 0, range: vk::WHOLE_SIZE }];
            let (buffers, images) = match binding {
                Binding::Uniform(b) | Binding::Storage(b) => (whole(b.raw), None),
                Binding::External(raw) => (whole(*raw), None),
                Binding::StorageImage(image) => (Default::default(), Some((image.view, vk::ImageLayout::GENERAL))),
                Binding::Sampled(image) => (Default::default(), Some((image.view, sync::SAMPLED))),
                Binding::SampledView(view, layout) => (Default::default(), Some((*view, *layout))),
                Binding::Structure(_) => (Default::default(), None),
            };
            let structures = match binding {
                Binding::Structure(structure) => [structure.raw],
                _ => [vk::AccelerationStructureKHR::null()],
            };
            let mut structure =
                vk::WriteDescriptorSetAccelerationStructureKHR::default().acceleration_structures(&structures);
            let images = images.map(|(image_view, image_layout)| {
                [vk::DescriptorImageInfo { sampler: self.sampler, image_view, image_layout }]
            });
            let mut write = vk::WriteDescriptorSet::default()
                .dst_set(self.set)
                .dst_binding(i as u32)
                .descriptor_type(binding.kind());
            write = match (binding, &images) {
                (Binding::Structure(_), _) => write.push_next(&mut structure).descriptor_count(1),
                (_, Some(images)) => write.image_info(images),
                (_, None) => write.buffer_info(&buffers),
            };
            // SAFETY: the set was just allocated and is not in use
            unsafe { self.gpu.device.update_descriptor_sets(&[write], &[]) };
        }
    }

    fn bind<P: Pod>(&self, cmd: vk::CommandBuffer, point: vk::PipelineBindPoint, pipeline: vk::Pipeline, push: &P) {
        let bytes = bytemuck::bytes_of(push);
        assert_eq!(bytes.len() as u32, self.push_size, "push constants of {}", self.name);
        // SAFETY: the command buffer is recording; set and pipeline share this layout
        unsafe {
            let device = &self.gpu.device;
            self.gpu.insert_label(cmd, &self.label);
            device.cmd_bind_pipeline(cmd, point, pipeline);
            if self.set != vk::DescriptorSet::null() {
                device.cmd_bind_descriptor_sets(cmd, point, self.layout, 0, &[self.set], &[]);
            }
            if !bytes.is_empty() {
                device.cmd_push_constants(cmd, self.layout, self.stages, 0, bytes);
            }
        }
    }
}

impl Drop for Layout {
    fn drop(&mut self) {
        // SAFETY: the owner waits for the GPU before dropping pipelines
        unsafe {
            let device = &self.gpu.device;
            device.destroy_descriptor_pool(self.pool, None);
            device.destroy_sampler(self.sampler, None);
            device.destroy_pipeline_layout(self.layout, None);
            device.destroy_descriptor_set_layout(self.set_layout, None);
        }
    }
}

/// A set that a host binds in pipelines of its own; the engine makes none with it.
pub(crate) struct HostSet(Layout);

impl HostSet {
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        name: &'static str,
        stages: vk::ShaderStageFlags,
        bindings: &[Binding<'_>],
    ) -> Result<Self, Error> {
        Ok(Self(Layout::new(gpu, name, stages, bindings, 0)?))
    }

    pub(crate) fn handles(&self) -> (vk::DescriptorSetLayout, vk::DescriptorSet) {
        (self.0.set_layout, self.0.set)
    }
}

/// A shader, needed no longer than a pipeline of it is made.
struct Module<'a> {
    raw: vk::ShaderModule,
    gpu: &'a Gpu,
}

impl<'a> Module<'a> {
    /// `bytes`: SPIR-V words.
    fn new(gpu: &'a Gpu, name: &str, bytes: &[u8]) -> Result<Self, Error> {
        let words = ash::util::read_spv(&mut std::io::Cursor::new(bytes))
            .map_err(|error| Error::Unsupported { what: format!("shader {name}: {error}") })?;
        let info = vk::ShaderModuleCreateInfo::default().code(&words);
        // SAFETY: the words passed spirv-val when they were built
        let raw = unsafe { gpu.device.create_shader_module(&info, None) }.context("vkCreateShaderModule")?;
        Ok(Self { raw, gpu })
    }
}

impl Drop for Module<'_> {
    fn drop(&mut self) {
        // SAFETY: the pipeline is made, or will not be
        unsafe { self.gpu.device.destroy_shader_module(self.raw, None) };
    }
}

/// Specialization constants 0, 1, 2, ... as 32-bit words.
fn specialization(constants: &[u32]) -> (Vec<vk::SpecializationMapEntry>, &[u8]) {
    let entries = (0..constants.len() as u32)
        .map(|i| vk::SpecializationMapEntry { constant_id: i, offset: 4 * i, size: 4 })
        .collect();
    (entries, bytemuck::cast_slice(constants))
}

/// A compute pipeline. The only type that makes and runs one.
pub(crate) struct Compute {
    pipeline: vk::Pipeline,
    layout: Layout,
}

impl Compute {
    /// `bindings` in binding order, `constants` in the order of their ids, `push_size` in bytes.
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        name: &'static str,
        spirv: &[u8],
        bindings: &[Binding<'_>],
        constants: &[u32],
        push_size: usize,
    ) -> Result<Self, Error> {
        let layout = Layout::new(gpu, name, vk::ShaderStageFlags::COMPUTE, bindings, push_size as u32)?;
        let module = Module::new(gpu, name, spirv)?;
        let (entries, data) = specialization(constants);
        let constants = vk::SpecializationInfo::default().map_entries(&entries).data(data);
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module.raw)
            .name(c"main")
            .specialization_info(&constants);
        let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(layout.layout)];
        // SAFETY: module and layout are valid
        let made = unsafe { gpu.device.create_compute_pipelines(vk::PipelineCache::null(), &info, None) };
        let pipeline = made.map_err(|(_, result)| result).context("vkCreateComputePipelines")?[0];
        gpu.name(pipeline, name);
        Ok(Self { pipeline, layout })
    }

    /// Records a dispatch of `groups` workgroups.
    pub(crate) fn dispatch<P: Pod>(&self, cmd: vk::CommandBuffer, push: &P, groups: [u32; 3]) {
        self.layout.bind(cmd, vk::PipelineBindPoint::COMPUTE, self.pipeline, push);
        // SAFETY: pipeline and set are bound
        unsafe { self.layout.gpu.device.cmd_dispatch(cmd, groups[0], groups[1], groups[2]) };
    }

    /// Records a dispatch whose size lies in `buffer` at `offset` bytes.
    pub(crate) fn dispatch_indirect<P: Pod>(&self, cmd: vk::CommandBuffer, push: &P, buffer: &Buffer, offset: u64) {
        self.layout.bind(cmd, vk::PipelineBindPoint::COMPUTE, self.pipeline, push);
        // SAFETY: pipeline and set are bound; the buffer has indirect usage
        unsafe { self.layout.gpu.device.cmd_dispatch_indirect(cmd, buffer.raw, offset) };
    }
}

impl Drop for Compute {
    fn drop(&mut self) {
        // SAFETY: the owner waits for the GPU before dropping pipelines
        unsafe { self.layout.gpu.device.destroy_pipeline(self.pipeline, None) };
    }
}

/// The shaders of a graphics pipeline; all stages get the same constants.
pub(crate) struct Shaders<'a> {
    pub(crate) vertex: &'a [u8],
    /// Control and evaluation, on devices that have tessellation; patches are then triangles.
    pub(crate) tessellation: Option<[&'a [u8]; 2]>,
    pub(crate) fragment: Option<&'a [u8]>,
    /// In the order of their ids.
    pub(crate) constants: &'a [u32],
}

/// Fixed state of a graphics pipeline; triangles, no culling, dynamic viewport and scissor.
pub(crate) struct GraphicsState<'a> {
    /// Where the `vec3` positions for location 0 lie in binding 0, if there are any.
    pub(crate) positions: Option<PositionLayout>,
    /// Whether binding 1 delivers texture coordinates (location 1) and colour (location 2).
    pub(crate) attributes: bool,
    pub(crate) colors: &'a [vk::Format],
    pub(crate) depth_compare: vk::CompareOp,
    pub(crate) cull: vk::CullModeFlags,
}

impl GraphicsState<'static> {
    /// Casters into a depth image, nearest first; with attributes where fragments are tested.
    pub(crate) const fn casters(positions: PositionLayout, attributes: bool) -> Self {
        Self {
            positions: Some(positions),
            attributes,
            colors: &[],
            depth_compare: vk::CompareOp::LESS_OR_EQUAL,
            cull: vk::CullModeFlags::NONE,
        }
    }
}

/// Sets viewport and scissor to the whole of an attachment.
pub(crate) fn set_area(device: &ash::Device, cmd: vk::CommandBuffer, area: vk::Rect2D) {
    let (width, height) = (area.extent.width as f32, area.extent.height as f32);
    let viewport = vk::Viewport { x: 0.0, y: 0.0, width, height, min_depth: 0.0, max_depth: 1.0 };
    // SAFETY: the command buffer is recording
    unsafe {
        device.cmd_set_viewport(cmd, 0, &[viewport]);
        device.cmd_set_scissor(cmd, 0, &[area]);
    }
}

/// A graphics pipeline for dynamic rendering with a D32 depth attachment.
pub(crate) struct Graphics {
    pipeline: vk::Pipeline,
    layout: Layout,
}

impl Graphics {
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        name: &'static str,
        shaders: &Shaders<'_>,
        bindings: &[Binding<'_>],
        state: &GraphicsState<'_>,
    ) -> Result<Self, Error> {
        use vk::ShaderStageFlags as Stage;
        let mut stages = vec![(Stage::VERTEX, shaders.vertex)];
        if let Some([control, evaluation]) = shaders.tessellation {
            stages.extend([(Stage::TESSELLATION_CONTROL, control), (Stage::TESSELLATION_EVALUATION, evaluation)]);
        }
        let visible = stages.iter().fold(Stage::VERTEX | Stage::FRAGMENT, |all, (stage, _)| all | *stage);
        stages.extend(shaders.fragment.map(|fragment| (Stage::FRAGMENT, fragment)));
        let layout = Layout::new(gpu, name, visible, bindings, 0)?;
        let (entries, data) = specialization(shaders.constants);
        let constants = vk::SpecializationInfo::default().map_entries(&entries).data(data);
        let modules = stages
            .iter()
            .map(|(stage, words)| Ok((*stage, Module::new(gpu, name, words)?)))
            .collect::<Result<Vec<_>, Error>>()?;
        let shader_stages: Vec<_> = modules
            .iter()
            .map(|(stage, module)| {
                vk::PipelineShaderStageCreateInfo::default()
                    .stage(*stage)
                    .module(module.raw)
                    .name(c"main")
                    .specialization_info(&constants)
            })
            .collect();
        let mut vertex_bindings = Vec::new();
        let mut vertex_attributes = Vec::new();
        let attribute = |location, binding, format, offset| vk::VertexInputAttributeDescription {
            location,
            binding,
            format,
            offset,
        };
        if let Some(PositionLayout { format, stride, offset }) = state.positions {
            vertex_bindings.push(vk::VertexInputBindingDescription {
                binding: 0,
                stride,
                input_rate: vk::VertexInputRate::VERTEX,
            });
            vertex_attributes.push(attribute(0, 0, format.vulkan(), offset));
        }
        if state.attributes {
            vertex_bindings.push(vk::VertexInputBindingDescription {
                binding: 1,
                stride: 12,
                input_rate: vk::VertexInputRate::VERTEX,
            });
            vertex_attributes.push(attribute(1, 1, vk::Format::R32G32_SFLOAT, 0));
            vertex_attributes.push(attribute(2, 1, vk::Format::R8G8B8A8_UNORM, 8));
        }
        let vertex_input = vk::PipelineVertexInputStateCreateInfo::default()
            .vertex_binding_descriptions(&vertex_bindings)
            .vertex_attribute_descriptions(&vertex_attributes);
        let patches = vk::PipelineTessellationStateCreateInfo::default().patch_control_points(3);
        let topology = match shaders.tessellation {
            Some(_) => vk::PrimitiveTopology::PATCH_LIST,
            None => vk::PrimitiveTopology::TRIANGLE_LIST,
        };
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(topology);
        let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
        let raster = vk::PipelineRasterizationStateCreateInfo::default()
            .cull_mode(state.cull)
            .front_face(vk::FrontFace::COUNTER_CLOCKWISE)
            .line_width(1.0);
        let samples =
            vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(vk::SampleCountFlags::TYPE_1);
        let depth = vk::PipelineDepthStencilStateCreateInfo::default()
            .depth_test_enable(true)
            .depth_write_enable(true)
            .depth_compare_op(state.depth_compare);
        let blend_targets = vec![
            vk::PipelineColorBlendAttachmentState::default()
                .color_write_mask(vk::ColorComponentFlags::RGBA);
            state.colors.len()
        ];
        let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blend_targets);
        let dynamic_states = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
        let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic_states);
        let mut rendering = vk::PipelineRenderingCreateInfo::default()
            .color_attachment_formats(state.colors)
            .depth_attachment_format(vk::Format::D32_SFLOAT);
        let info = [vk::GraphicsPipelineCreateInfo::default()
            .stages(&shader_stages)
            .vertex_input_state(&vertex_input)
            .input_assembly_state(&assembly)
            .tessellation_state(&patches)
            .viewport_state(&viewport)
            .rasterization_state(&raster)
            .multisample_state(&samples)
            .depth_stencil_state(&depth)
            .color_blend_state(&blend)
            .dynamic_state(&dynamic)
            .layout(layout.layout)
            .push_next(&mut rendering)];
        // SAFETY: everything referenced lives through the call
        let made = unsafe { gpu.device.create_graphics_pipelines(vk::PipelineCache::null(), &info, None) };
        let pipeline = made.map_err(|(_, result)| result).context("vkCreateGraphicsPipelines")?[0];
        gpu.name(pipeline, name);
        Ok(Self { pipeline, layout })
    }

    /// Binds pipeline and set; draws follow.
    pub(crate) fn bind(&self, cmd: vk::CommandBuffer) {
        self.layout.bind(cmd, vk::PipelineBindPoint::GRAPHICS, self.pipeline, &());
    }
}

impl Drop for Graphics {
    fn drop(&mut self) {
        // SAFETY: the owner waits for the GPU before dropping pipelines
        unsafe { self.layout.gpu.device.destroy_pipeline(self.pipeline, None) };
    }
}
