//! The renderer's own Vulkan: a device, buffers and images that live until it ends, two pipelines.

use super::{POSITIONS, Result, SIZE};
use ash::vk;
use glam::{DMat4, DVec3};
use std::cell::RefCell;
use std::ffi::c_void;
use std::sync::atomic::{AtomicU32, Ordering};
use umbrage::scene::Scene;
use umbrage::{FrameInput, HostDevice, ImageUse, SceneBuffers, ShaderSet};
use vk::{AccessFlags2 as A, ImageLayout as L, PipelineStageFlags2 as S};

/// An image and a view of all of it.
pub type Image = (vk::Image, vk::ImageView);

/// Instance, device, queue and all that was made on it; nothing is freed before the end.
pub struct Vulkan {
    /// As Umbrage gets it.
    pub host: HostDevice,
    queue: vk::Queue,
    pool: vk::CommandPool,
    cmd: vk::CommandBuffer,
    memory: vk::PhysicalDeviceMemoryProperties,
    made: RefCell<Made>,
    _entry: ash::Entry,
}

#[derive(Default)]
struct Made {
    memory: Vec<vk::DeviceMemory>,
    buffers: Vec<vk::Buffer>,
    images: Vec<Image>,
    samplers: Vec<vk::Sampler>,
    pipelines: Vec<Pipeline>,
}

#[derive(Clone, Copy, Default)]
pub struct Pipeline {
    pipeline: vk::Pipeline,
    layout: vk::PipelineLayout,
    set_layout: vk::DescriptorSetLayout,
    pool: vk::DescriptorPool,
    set: vk::DescriptorSet,
    /// The stage that has push constants.
    pushed: vk::ShaderStageFlags,
}

// SAFETY of all calls below: handles are alive until `drop`, infos are complete, the only command buffer is waited for
// before it is used again.
#[allow(clippy::undocumented_unsafe_blocks)]
impl Vulkan {
    /// On the first device on which Umbrage runs.
    pub fn new(validation: bool) -> Result<Self> {
        unsafe {
            let entry = ash::Entry::load()?;
            let app = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
            let layers: Vec<*const i8> =
                validation.then_some(c"VK_LAYER_KHRONOS_validation".as_ptr()).into_iter().collect();
            let names: Vec<*const i8> =
                validation.then_some(ash::ext::debug_utils::NAME.as_ptr()).into_iter().collect();
            let enables = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
            let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enables);
            use vk::{DebugUtilsMessageSeverityFlagsEXT as S, DebugUtilsMessageTypeFlagsEXT as T};
            let mut messages = vk::DebugUtilsMessengerCreateInfoEXT::default()
                .message_severity(S::ERROR | S::WARNING)
                .message_type(T::VALIDATION | T::PERFORMANCE)
                .pfn_user_callback(Some(on_message));
            let mut info = vk::InstanceCreateInfo::default()
                .application_info(&app)
                .enabled_layer_names(&layers)
                .enabled_extension_names(&names);
            if validation {
                info = info.push_next(&mut features).push_next(&mut messages);
            }
            let instance = entry.create_instance(&info, None)?;
            // the first device on which Umbrage runs
            let devices = instance.enumerate_physical_devices()?;
            let usable = |d: &vk::PhysicalDevice| umbrage::missing_features(&instance, *d).is_empty();
            let physical_device = devices.into_iter().find(usable).ok_or("no device has what Umbrage needs")?;
            let mut needs = umbrage::requirements(&instance, physical_device);
            let families = instance.get_physical_device_queue_family_properties(physical_device);
            let wanted = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
            let family =
                families.iter().position(|f| f.queue_flags.contains(wanted)).ok_or("no graphics queue")? as u32;
            let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&[1.0])];
            // features of the host's own are switched on in the same structs
            let has = instance.get_physical_device_features(physical_device);
            needs.features.tessellation_shader = has.tessellation_shader;
            let info = vk::DeviceCreateInfo::default()
                .queue_create_infos(&queues)
                .enabled_features(&needs.features)
                .push_next(&mut needs.vulkan12)
                .push_next(&mut needs.vulkan13);
            let device = instance.create_device(physical_device, &info, None)?;
            let pool = vk::CommandPoolCreateInfo::default()
                .queue_family_index(family)
                .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
            let pool = device.create_command_pool(&pool, None)?;
            let info = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
            Ok(Self {
                queue: device.get_device_queue(family, 0),
                cmd: device.allocate_command_buffers(&info)?[0],
                pool,
                memory: instance.get_physical_device_memory_properties(physical_device),
                host: HostDevice { instance, physical_device, device, debug_utils: validation, ray_query: false },
                made: RefCell::default(),
                _entry: entry,
            })
        }
    }

    fn allocate(&self, needs: vk::MemoryRequirements, wanted: vk::MemoryPropertyFlags) -> Result<vk::DeviceMemory> {
        let types = self.memory.memory_types_as_slice().iter().enumerate();
        let fits = |&(i, t): &(usize, &vk::MemoryType)| {
            needs.memory_type_bits & 1 << i != 0 && t.property_flags.contains(wanted)
        };
        let index = types.into_iter().find(fits).ok_or("no such memory")?.0 as u32;
        let info = vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(index);
        let memory = unsafe { self.host.device.allocate_memory(&info, None)? };
        self.made.borrow_mut().memory.push(memory);
        Ok(memory)
    }

    /// A buffer that the CPU sees, and where.
    pub fn host_visible(&self, size: u64, usage: vk::BufferUsageFlags) -> Result<(vk::Buffer, *mut u8)> {
        unsafe {
            let device = &self.host.device;
            let buffer = device.create_buffer(&vk::BufferCreateInfo::default().size(size).usage(usage), None)?;
            self.made.borrow_mut().buffers.push(buffer);
            use vk::MemoryPropertyFlags as M;
            let memory =
                self.allocate(device.get_buffer_memory_requirements(buffer), M::HOST_VISIBLE | M::HOST_COHERENT)?;
            device.bind_buffer_memory(buffer, memory, 0)?;
            Ok((buffer, device.map_memory(memory, 0, size, vk::MemoryMapFlags::empty())?.cast()))
        }
    }

    /// A buffer with these bytes.
    pub fn buffer(&self, bytes: &[u8], usage: vk::BufferUsageFlags) -> Result<vk::Buffer> {
        let (buffer, to) = self.host_visible(bytes.len() as u64, usage)?;
        unsafe { std::ptr::copy_nonoverlapping(bytes.as_ptr(), to, bytes.len()) };
        Ok(buffer)
    }

    /// An image as large as the picture.
    pub fn image(&self, format: vk::Format, usage: vk::ImageUsageFlags) -> Result<Image> {
        unsafe {
            let device = &self.host.device;
            let info = vk::ImageCreateInfo::default()
                .image_type(vk::ImageType::TYPE_2D)
                .format(format)
                .extent(vk::Extent3D { width: SIZE[0], height: SIZE[1], depth: 1 })
                .mip_levels(1)
                .array_layers(1)
                .samples(vk::SampleCountFlags::TYPE_1)
                .usage(usage);
            let image = device.create_image(&info, None)?;
            let memory =
                self.allocate(device.get_image_memory_requirements(image), vk::MemoryPropertyFlags::DEVICE_LOCAL)?;
            device.bind_image_memory(image, memory, 0)?;
            let info = vk::ImageViewCreateInfo::default()
                .image(image)
                .view_type(vk::ImageViewType::TYPE_2D)
                .format(format)
                .subresource_range(whole(format));
            let made = (image, device.create_image_view(&info, None)?);
            self.made.borrow_mut().images.push(made);
            Ok(made)
        }
    }

    fn module(&self, bytes: &[u8]) -> Result<vk::ShaderModule> {
        let words = ash::util::read_spv(&mut std::io::Cursor::new(bytes))?;
        Ok(unsafe { self.host.device.create_shader_module(&vk::ShaderModuleCreateInfo::default().code(&words), None)? })
    }

    /// Draws the scene.
    pub fn draw_pipeline(&self, pass: Pass) -> Result<Pipeline> {
        unsafe {
            let device = &self.host.device;
            use vk::ShaderStageFlags as Stage;
            // what a pass binds, how many colours it draws, which shaders do it and which of these has push constants
            let (set, colors, pushed, shaders): (_, _, _, &[(Stage, &[u8])]) = match pass {
                Pass::Camera => (
                    None,
                    2,
                    (Stage::VERTEX, CAMERA_PUSH),
                    &[
                        (Stage::VERTEX, include_bytes!("../../spirv/examples/host.vert.spv")),
                        (Stage::FRAGMENT, include_bytes!("../../spirv/examples/host.frag.spv")),
                    ],
                ),
                Pass::Forward(lookup) => (
                    Some(lookup),
                    1,
                    (Stage::VERTEX, CAMERA_PUSH),
                    &[
                        (Stage::VERTEX, include_bytes!("../../spirv/examples/host.vert.spv")),
                        (Stage::FRAGMENT, include_bytes!("../../spirv/examples/forward.frag.spv")),
                    ],
                ),
                Pass::Casters(casters) => (
                    Some(casters),
                    0,
                    (Stage::VERTEX, 4),
                    &[(Stage::VERTEX, include_bytes!("../../spirv/examples/casters.vert.spv"))],
                ),
                Pass::Patches(casters) => (
                    Some(casters),
                    0,
                    (Stage::TESSELLATION_EVALUATION, 4),
                    &[
                        (Stage::VERTEX, include_bytes!("../../spirv/examples/patches.vert.spv")),
                        (Stage::TESSELLATION_CONTROL, include_bytes!("../../spirv/examples/patches.tesc.spv")),
                        (Stage::TESSELLATION_EVALUATION, include_bytes!("../../spirv/examples/patches.tese.spv")),
                    ],
                ),
            };
            let push = [vk::PushConstantRange { stage_flags: pushed.0, offset: 0, size: pushed.1 }];
            let layouts: Vec<_> = set.iter().map(|set| set.layout).collect();
            let info = vk::PipelineLayoutCreateInfo::default().push_constant_ranges(&push).set_layouts(&layouts);
            let layout = device.create_pipeline_layout(&info, None)?;
            let modules = shaders.iter().map(|(_, bytes)| self.module(bytes)).collect::<Result<Vec<_>>>()?;
            let stage = |(&(stage, _), &module): (&(_, _), _)| {
                vk::PipelineShaderStageCreateInfo::default().stage(stage).module(module).name(c"main")
            };
            let stages: Vec<_> = shaders.iter().zip(&modules).map(stage).collect();
            let bindings = [vk::VertexInputBindingDescription {
                binding: 0,
                stride: POSITIONS.stride,
                input_rate: vk::VertexInputRate::VERTEX,
            }];
            let format = vk::Format::R32G32B32_SFLOAT;
            let attributes =
                [vk::VertexInputAttributeDescription { location: 0, binding: 0, format, offset: POSITIONS.offset }];
            let input = vk::PipelineVertexInputStateCreateInfo::default()
                .vertex_binding_descriptions(&bindings)
                .vertex_attribute_descriptions(&attributes);
            let patches = matches!(pass, Pass::Patches(_));
            let topology =
                if patches { vk::PrimitiveTopology::PATCH_LIST } else { vk::PrimitiveTopology::TRIANGLE_LIST };
            let assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(topology);
            let tessellation = vk::PipelineTessellationStateCreateInfo::default().patch_control_points(3);
            let viewports = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
            let states = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
            let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&states);
            let raster = vk::PipelineRasterizationStateCreateInfo::default().line_width(1.0);
            let samples =
                vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(vk::SampleCountFlags::TYPE_1);
            // reversed depth: nearer is greater
            let depth = vk::PipelineDepthStencilStateCreateInfo::default()
                .depth_test_enable(true)
                .depth_write_enable(true)
                .depth_compare_op(vk::CompareOp::GREATER_OR_EQUAL);
            let all = vk::PipelineColorBlendAttachmentState::default().color_write_mask(vk::ColorComponentFlags::RGBA);
            let blends = [all; 2];
            let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blends[..colors]);
            let formats = [vk::Format::R8G8B8A8_UNORM, vk::Format::R32_UINT];
            let mut rendering = vk::PipelineRenderingCreateInfo::default()
                .color_attachment_formats(&formats[..colors])
                .depth_attachment_format(vk::Format::D32_SFLOAT);
            let mut info = vk::GraphicsPipelineCreateInfo::default()
                .stages(&stages)
                .vertex_input_state(&input)
                .input_assembly_state(&assembly)
                .viewport_state(&viewports)
                .rasterization_state(&raster)
                .multisample_state(&samples)
                .depth_stencil_state(&depth)
                .color_blend_state(&blend)
                .dynamic_state(&dynamic)
                .layout(layout)
                .push_next(&mut rendering);
            if patches {
                info = info.tessellation_state(&tessellation);
            }
            let made = device.create_graphics_pipelines(vk::PipelineCache::null(), &[info], None).map_err(|e| e.1)?[0];
            modules.into_iter().for_each(|module| device.destroy_shader_module(module, None));
            let set = set.map_or(vk::DescriptorSet::null(), |set| set.set);
            Ok(self.keep(Pipeline { pipeline: made, layout, set, pushed: pushed.0, ..Default::default() }))
        }
    }

    /// Shades by the mask.
    pub fn shade_pipeline(&self, color: vk::ImageView, mask: vk::ImageView, pixels: vk::Buffer) -> Result<Pipeline> {
        unsafe {
            let device = &self.host.device;
            use vk::DescriptorType as D;
            let kinds = [D::COMBINED_IMAGE_SAMPLER, D::COMBINED_IMAGE_SAMPLER, D::STORAGE_BUFFER];
            let binding = |(i, kind): (u32, &D)| {
                let slot = vk::DescriptorSetLayoutBinding::default().binding(i).descriptor_type(*kind);
                slot.descriptor_count(1).stage_flags(vk::ShaderStageFlags::COMPUTE)
            };
            let bindings: Vec<_> = (0..).zip(&kinds).map(binding).collect();
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            let set_layout = device.create_descriptor_set_layout(&info, None)?;
            let sizes = kinds.map(|ty| vk::DescriptorPoolSize { ty, descriptor_count: 1 });
            let info = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
            let pool = device.create_descriptor_pool(&info, None)?;
            let layouts = [set_layout];
            let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
            let set = device.allocate_descriptor_sets(&info)?[0];
            let sampler = device.create_sampler(&vk::SamplerCreateInfo::default(), None)?;
            self.made.borrow_mut().samplers.push(sampler);
            let image_layout = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;
            let sampled = |image_view| [vk::DescriptorImageInfo { sampler, image_view, image_layout }];
            let (color, mask) = (sampled(color), sampled(mask));
            let pixels = [vk::DescriptorBufferInfo { buffer: pixels, offset: 0, range: vk::WHOLE_SIZE }];
            let write = |i: usize| {
                vk::WriteDescriptorSet::default().dst_set(set).dst_binding(i as u32).descriptor_type(kinds[i])
            };
            let writes = [write(0).image_info(&color), write(1).image_info(&mask), write(2).buffer_info(&pixels)];
            device.update_descriptor_sets(&writes, &[]);
            let layout =
                device.create_pipeline_layout(&vk::PipelineLayoutCreateInfo::default().set_layouts(&layouts), None)?;
            let module = self.module(include_bytes!("../../spirv/examples/host.comp.spv"))?;
            let stage = vk::PipelineShaderStageCreateInfo::default().stage(vk::ShaderStageFlags::COMPUTE);
            let info =
                vk::ComputePipelineCreateInfo::default().stage(stage.module(module).name(c"main")).layout(layout);
            let made = device.create_compute_pipelines(vk::PipelineCache::null(), &[info], None).map_err(|e| e.1)?[0];
            device.destroy_shader_module(module, None);
            Ok(self.keep(Pipeline { pipeline: made, layout, set_layout, pool, set, ..Default::default() }))
        }
    }

    fn keep(&self, pipeline: Pipeline) -> Pipeline {
        self.made.borrow_mut().pipelines.push(pipeline);
        pipeline
    }

    /// The host's pass before Umbrage: leaves depth and normals as attachments, colour readable.
    pub fn draw(&self, cmd: vk::CommandBuffer, pipeline: &Pipeline, images: [Image; 3], what: &Geometry<'_>) {
        let [color, normal, depth] = images;
        // the last frame's passes may still read them
        let before = (S::COMPUTE_SHADER | WRITTEN.0 | TESTED.0, A::NONE, L::UNDEFINED);
        self.transition(cmd, color.0, vk::Format::R8G8B8A8_UNORM, before, WRITTEN);
        self.transition(cmd, normal.0, vk::Format::R32_UINT, before, WRITTEN);
        self.transition(cmd, depth.0, vk::Format::D32_SFLOAT, before, TESTED);
        self.geometry(cmd, pipeline, &[color.1, normal.1], depth.1, vk::AttachmentLoadOp::CLEAR, what);
        let read = (S::COMPUTE_SHADER, A::SHADER_SAMPLED_READ, L::SHADER_READ_ONLY_OPTIMAL);
        self.transition(cmd, color.0, vk::Format::R8G8B8A8_UNORM, WRITTEN, read);
    }

    /// The host's pass after Umbrage that looks shadows up itself, over the depth of the pass before; copied to `pixels`.
    pub fn forward(
        &self,
        cmd: vk::CommandBuffer,
        pipeline: &Pipeline,
        [color, depth]: [Image; 2],
        pixels: vk::Buffer,
        what: &Geometry<'_>,
    ) {
        let before = (S::ALL_TRANSFER, A::NONE, L::UNDEFINED);
        self.transition(cmd, color.0, vk::Format::R8G8B8A8_UNORM, before, WRITTEN);
        self.geometry(cmd, pipeline, &[color.1], depth.1, vk::AttachmentLoadOp::LOAD, what);
        let copied = (S::ALL_TRANSFER, A::TRANSFER_READ, L::TRANSFER_SRC_OPTIMAL);
        self.transition(cmd, color.0, vk::Format::R8G8B8A8_UNORM, WRITTEN, copied);
        let aspect_mask = vk::ImageAspectFlags::COLOR;
        let layers = vk::ImageSubresourceLayers { aspect_mask, layer_count: 1, ..Default::default() };
        let extent = vk::Extent3D { width: SIZE[0], height: SIZE[1], depth: 1 };
        let region = [vk::BufferImageCopy::default().image_subresource(layers).image_extent(extent)];
        unsafe { self.host.device.cmd_copy_image_to_buffer(cmd, color.0, L::TRANSFER_SRC_OPTIMAL, pixels, &region) };
        self.to_host(cmd, S::ALL_TRANSFER, A::TRANSFER_WRITE);
    }

    fn geometry(
        &self,
        cmd: vk::CommandBuffer,
        pipeline: &Pipeline,
        colors: &[vk::ImageView],
        depth: vk::ImageView,
        depth_load: vk::AttachmentLoadOp,
        Geometry { buffers, scene, input, wind }: &Geometry<'_>,
    ) {
        unsafe {
            let device = &self.host.device;
            let target = |view, image_layout, load| {
                let info = vk::RenderingAttachmentInfo::default().image_view(view).image_layout(image_layout);
                info.load_op(load).store_op(vk::AttachmentStoreOp::STORE)
            };
            let clear = vk::AttachmentLoadOp::CLEAR;
            let colors: Vec<_> = colors.iter().map(|&view| target(view, L::COLOR_ATTACHMENT_OPTIMAL, clear)).collect();
            let depth = target(depth, L::DEPTH_ATTACHMENT_OPTIMAL, depth_load);
            let info = vk::RenderingInfo::default()
                .render_area(viewport().1[0])
                .layer_count(1)
                .color_attachments(&colors)
                .depth_attachment(&depth);
            device.cmd_begin_rendering(cmd, &info);
            device.cmd_set_viewport(cmd, 0, &viewport().0);
            device.cmd_set_scissor(cmd, 0, &viewport().1);
            let point = vk::PipelineBindPoint::GRAPHICS;
            device.cmd_bind_pipeline(cmd, point, pipeline.pipeline);
            if pipeline.set != vk::DescriptorSet::null() {
                device.cmd_bind_descriptor_sets(cmd, point, pipeline.layout, 0, &[pipeline.set], &[]);
            }
            device.cmd_bind_vertex_buffers(cmd, 0, &[buffers.positions], &[0]);
            device.cmd_bind_index_buffer(cmd, buffers.indices, 0, vk::IndexType::UINT32);
            let clip = input.clip_from_view * DMat4::from_mat3(input.view_from_world);
            for instance in &scene.instances {
                let mesh = scene.meshes[instance.mesh as usize];
                let offset = instance.translation() + input.origin - input.eye;
                let mut rows = instance.rows;
                (0..3).for_each(|i| rows[i][3] = offset[i] as f32);
                let column = |i: usize| DVec3::from_array([0, 1, 2].map(|r| f64::from(instance.rows[r][i])));
                let columns = [column(0).extend(0.0), column(1).extend(0.0), column(2).extend(0.0), offset.extend(1.0)];
                let [x, y, z, w] = columns;
                let clip_from_mesh = (clip * DMat4::from_cols(x, y, z, w)).as_mat4();
                let push =
                    [bytemuck::bytes_of(&clip_from_mesh), bytemuck::bytes_of(&rows), bytemuck::bytes_of(wind)].concat();
                device.cmd_push_constants(cmd, pipeline.layout, vk::ShaderStageFlags::VERTEX, 0, &push);
                device.cmd_draw_indexed(cmd, mesh.index_count, 1, mesh.first_index, 0, 0);
            }
            device.cmd_end_rendering(cmd);
        }
    }

    /// The casters that the host draws itself, inside of Umbrage's rendering: each into the pages that Umbrage found for it.
    pub fn casters(&self, cmd: vk::CommandBuffer, pipeline: &Pipeline, what: &Geometry<'_>) {
        let Some(draws) = what.buffers.host_draws else { return };
        unsafe {
            let device = &self.host.device;
            let point = vk::PipelineBindPoint::GRAPHICS;
            device.cmd_bind_pipeline(cmd, point, pipeline.pipeline);
            device.cmd_bind_descriptor_sets(cmd, point, pipeline.layout, 0, &[pipeline.set], &[]);
            device.cmd_push_constants(cmd, pipeline.layout, pipeline.pushed, 0, bytemuck::bytes_of(&what.wind));
            device.cmd_bind_vertex_buffers(cmd, 0, &[what.buffers.positions], &[0]);
            device.cmd_bind_index_buffer(cmd, what.buffers.indices, 0, vk::IndexType::UINT32);
            device.cmd_draw_indexed_indirect(cmd, draws, 0, what.buffers.instance_count, 20);
        }
    }

    /// The host's pass after Umbrage, which left the mask readable.
    pub fn shade(&self, cmd: vk::CommandBuffer, pipeline: &Pipeline) {
        unsafe {
            let device = &self.host.device;
            let point = vk::PipelineBindPoint::COMPUTE;
            device.cmd_bind_pipeline(cmd, point, pipeline.pipeline);
            device.cmd_bind_descriptor_sets(cmd, point, pipeline.layout, 0, &[pipeline.set], &[]);
            device.cmd_dispatch(cmd, SIZE[0].div_ceil(8), SIZE[1].div_ceil(8), 1);
            self.to_host(cmd, S::COMPUTE_SHADER, A::SHADER_STORAGE_WRITE);
        }
    }

    /// What these accesses wrote is read by the CPU.
    pub fn to_host(&self, cmd: vk::CommandBuffer, stage: S, access: A) {
        let barrier = vk::MemoryBarrier2::default().src_stage_mask(stage).src_access_mask(access);
        let barrier = [barrier.dst_stage_mask(S::HOST).dst_access_mask(A::HOST_READ)];
        let info = vk::DependencyInfo::default().memory_barriers(&barrier);
        unsafe { self.host.device.cmd_pipeline_barrier2(cmd, &info) };
    }

    fn transition(&self, cmd: vk::CommandBuffer, image: vk::Image, format: vk::Format, from: Use, to: Use) {
        let barrier = [vk::ImageMemoryBarrier2::default()
            .src_stage_mask(from.0)
            .src_access_mask(from.1)
            .old_layout(from.2)
            .dst_stage_mask(to.0)
            .dst_access_mask(to.1)
            .new_layout(to.2)
            .image(image)
            .subresource_range(whole(format))];
        let info = vk::DependencyInfo::default().image_memory_barriers(&barrier);
        unsafe { self.host.device.cmd_pipeline_barrier2(cmd, &info) };
    }

    /// Fills the command buffer.
    pub fn record(&self, record: impl FnOnce(vk::CommandBuffer)) -> Result<()> {
        unsafe {
            let device = &self.host.device;
            device.begin_command_buffer(self.cmd, &vk::CommandBufferBeginInfo::default())?;
            record(self.cmd);
            Ok(device.end_command_buffer(self.cmd)?)
        }
    }

    /// Fills the command buffer, runs it and waits.
    pub fn submit(&self, record: impl FnOnce(vk::CommandBuffer)) -> Result<()> {
        self.record(record)?;
        unsafe {
            let device = &self.host.device;
            let commands = [vk::CommandBufferSubmitInfo::default().command_buffer(self.cmd)];
            let submit = [vk::SubmitInfo2::default().command_buffer_infos(&commands)];
            device.queue_submit2(self.queue, &submit, vk::Fence::null())?;
            Ok(device.queue_wait_idle(self.queue)?)
        }
    }
}

type Use = (S, A, L);

const WRITTEN: Use = (S::COLOR_ATTACHMENT_OUTPUT, A::COLOR_ATTACHMENT_WRITE, L::COLOR_ATTACHMENT_OPTIMAL);
const TESTED: Use = {
    let ImageUse { layout, stage, access } = ImageUse::DEPTH_ATTACHMENT;
    (stage, access, layout)
};

/// What both passes over the scene draw.
pub struct Geometry<'a> {
    /// As Umbrage has it.
    pub buffers: &'a SceneBuffers,
    /// Meshes and instances.
    pub scene: &'a Scene,
    /// Where it is seen from.
    pub input: &'a FrameInput,
    /// How much everything is bent.
    pub wind: f32,
}

/// Bytes of push constants of `host.vert`.
const CAMERA_PUSH: u32 = 116;

/// What is drawn of the scene.
#[derive(Clone, Copy)]
pub enum Pass {
    /// Colour and normals.
    Camera,
    /// Colour, with shadows looked up.
    Forward(ShaderSet),
    /// Depth into the pages of the shadow map.
    Casters(ShaderSet),
    /// The same, tessellated.
    Patches(ShaderSet),
}

fn whole(format: vk::Format) -> vk::ImageSubresourceRange {
    let depth = format == vk::Format::D32_SFLOAT;
    let aspect_mask = if depth { vk::ImageAspectFlags::DEPTH } else { vk::ImageAspectFlags::COLOR };
    vk::ImageSubresourceRange { aspect_mask, level_count: 1, layer_count: 1, ..Default::default() }
}

fn viewport() -> ([vk::Viewport; 1], [vk::Rect2D; 1]) {
    let [width, height] = SIZE;
    let area = vk::Rect2D { offset: vk::Offset2D::default(), extent: vk::Extent2D { width, height } };
    let view =
        vk::Viewport { x: 0.0, y: 0.0, width: width as f32, height: height as f32, min_depth: 0.0, max_depth: 1.0 };
    ([view], [area])
}

/// Messages of the validation layer so far.
pub static MESSAGES: AtomicU32 = AtomicU32::new(0);

unsafe extern "system" fn on_message(
    _: vk::DebugUtilsMessageSeverityFlagsEXT,
    _: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    _: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layer passes valid data
    let text = unsafe { (*data).message_as_c_str() }.unwrap_or(c"?");
    eprintln!("validation: {}", text.to_string_lossy());
    MESSAGES.fetch_add(1, Ordering::Relaxed);
    vk::FALSE
}

#[allow(clippy::undocumented_unsafe_blocks)] // as above
impl Drop for Vulkan {
    fn drop(&mut self) {
        let made = self.made.take();
        unsafe {
            let device = &self.host.device;
            let _ = device.device_wait_idle();
            for p in made.pipelines {
                device.destroy_pipeline(p.pipeline, None);
                device.destroy_pipeline_layout(p.layout, None);
                device.destroy_descriptor_pool(p.pool, None);
                device.destroy_descriptor_set_layout(p.set_layout, None);
            }
            made.samplers.into_iter().for_each(|sampler| device.destroy_sampler(sampler, None));
            made.buffers.into_iter().for_each(|buffer| device.destroy_buffer(buffer, None));
            for (image, view) in made.images {
                device.destroy_image_view(view, None);
                device.destroy_image(image, None);
            }
            made.memory.into_iter().for_each(|memory| device.free_memory(memory, None));
            device.destroy_command_pool(self.pool, None);
            device.destroy_device(None);
            self.host.instance.destroy_instance(None);
        }
    }
}
