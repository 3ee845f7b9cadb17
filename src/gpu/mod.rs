//! A thin layer over raw Vulkan: resources that free themselves, typed pipelines, named accesses, timestamps.

mod pipeline;
mod resources;
pub mod structs;
mod structure;
pub(crate) mod sync;
#[cfg_attr(not(feature = "lab"), allow(dead_code))] // the lab makes and reads timers
mod timer;

pub(crate) use pipeline::{Binding, Compute, Graphics, GraphicsState, HostSet, Shaders, set_area};
pub(crate) use resources::{Buffer, Image, ImageSpec, Memory, aspects};
pub(crate) use structure::{Structure, instances};
pub(crate) use timer::Timer;

use crate::error::Error;
use ash::vk;
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use std::ffi::CStr;
use std::sync::{Arc, Mutex};

/// Handles of a Vulkan device that somebody else created, with the features of [`requirements`] enabled.
#[derive(Clone)]
pub struct HostDevice {
    /// The instance the device belongs to.
    pub instance: ash::Instance,
    /// The physical device.
    pub physical_device: vk::PhysicalDevice,
    /// The logical device.
    pub device: ash::Device,
    /// Whether `VK_EXT_debug_utils` is enabled on the instance, so that passes and objects get names.
    pub debug_utils: bool,
    /// Whether what [`Requirements::ray_query`] names is enabled on the device.
    pub ray_query: bool,
}

/// What ray queries need.
pub(crate) struct RayQueries {
    pub(crate) functions: ash::khr::acceleration_structure::Device,
    pub(crate) scratch_alignment: u64,
}

/// The device as the passes see it.
pub(crate) struct Gpu {
    pub(crate) device: ash::Device,
    pub(crate) limits: vk::PhysicalDeviceLimits,
    pub(crate) draw_indirect_count: bool,
    /// `None` where the host did not enable them.
    pub(crate) rays: Option<RayQueries>,
    pub(crate) allocator: Mutex<Option<Allocator>>,
    debug_utils: Option<ash::ext::debug_utils::Device>,
    /// Keeps a device of ours alive as long as anything made from it; dropped last.
    _owner: Option<Arc<dyn std::any::Any + Send + Sync>>,
}

impl Gpu {
    /// # Safety
    /// The handles must be valid and outlive the returned value and everything made from it.
    pub(crate) unsafe fn new(host: &HostDevice) -> Result<Arc<Self>, Error> {
        // SAFETY: the caller vouches for the handles
        unsafe { Self::owned(host, None) }
    }

    /// # Safety
    /// The handles must be valid and outlive the returned value, or be kept alive by `owner`.
    pub(crate) unsafe fn owned(
        host: &HostDevice,
        owner: Option<Arc<dyn std::any::Any + Send + Sync>>,
    ) -> Result<Arc<Self>, Error> {
        // SAFETY: the caller vouches for the handles
        let missing = unsafe { missing_features(&host.instance, host.physical_device) };
        if let Some(what) = missing.into_iter().next() {
            return Err(Error::Unsupported { what });
        }
        // SAFETY: the caller vouches for the handles
        let (properties, features) = unsafe {
            let mut vulkan12 = vk::PhysicalDeviceVulkan12Features::default();
            let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut vulkan12);
            host.instance.get_physical_device_features2(host.physical_device, &mut features);
            (host.instance.get_physical_device_properties(host.physical_device), vulkan12)
        };
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: host.instance.clone(),
            device: host.device.clone(),
            physical_device: host.physical_device,
            debug_settings: Default::default(),
            buffer_device_address: host.ray_query,
            allocation_sizes: Default::default(),
        })
        .map_err(|error| Error::Unsupported { what: format!("memory allocator: {error}") })?;
        let rays = host.ray_query.then(|| {
            let mut structure = vk::PhysicalDeviceAccelerationStructurePropertiesKHR::default();
            let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut structure);
            // SAFETY: the caller vouches for the handles
            unsafe { host.instance.get_physical_device_properties2(host.physical_device, &mut properties) };
            RayQueries {
                functions: ash::khr::acceleration_structure::Device::new(&host.instance, &host.device),
                scratch_alignment: u64::from(structure.min_acceleration_structure_scratch_offset_alignment.max(1)),
            }
        });
        let debug_utils = host.debug_utils.then(|| ash::ext::debug_utils::Device::new(&host.instance, &host.device));
        Ok(Arc::new(Self {
            device: host.device.clone(),
            limits: properties.limits,
            draw_indirect_count: features.draw_indirect_count == vk::TRUE,
            rays,
            allocator: Mutex::new(Some(allocator)),
            debug_utils,
            _owner: owner,
        }))
    }

    /// What ray queries need.
    pub(crate) fn ray_queries(&self) -> Result<&RayQueries, Error> {
        self.rays
            .as_ref()
            .ok_or_else(|| Error::Unsupported { what: "ray queries are not enabled on the device".into() })
    }

    /// Names an object for debuggers and validation messages.
    pub(crate) fn name<H: vk::Handle>(&self, handle: H, name: &str) {
        let (Some(utils), Ok(text)) = (&self.debug_utils, std::ffi::CString::new(name)) else { return };
        let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(handle).object_name(&text);
        // SAFETY: the handle was just created on this device; a failure only costs the name
        let _ = unsafe { utils.set_debug_utils_object_name(&info) };
    }

    /// Opens a debug region in the command buffer; closed by [`Gpu::end_label`].
    pub(crate) fn begin_label(&self, cmd: vk::CommandBuffer, name: &CStr) {
        if let Some(utils) = &self.debug_utils {
            // SAFETY: the command buffer is recording
            unsafe { utils.cmd_begin_debug_utils_label(cmd, &vk::DebugUtilsLabelEXT::default().label_name(name)) };
        }
    }

    /// Names what is recorded next.
    pub(crate) fn insert_label(&self, cmd: vk::CommandBuffer, name: &CStr) {
        if let Some(utils) = &self.debug_utils {
            // SAFETY: the command buffer is recording
            unsafe { utils.cmd_insert_debug_utils_label(cmd, &vk::DebugUtilsLabelEXT::default().label_name(name)) };
        }
    }

    /// Closes the innermost debug region.
    pub(crate) fn end_label(&self, cmd: vk::CommandBuffer) {
        if let Some(utils) = &self.debug_utils {
            // SAFETY: pairs with `begin_label` on the same recording command buffer
            unsafe { utils.cmd_end_debug_utils_label(cmd) };
        }
    }
}

/// Storage buffers of the pass that has most: the least `maxPerStageDescriptorStorageBuffers` of a device.
pub const STORAGE_BUFFERS: u32 = 13;
/// Threads of the largest workgroup: the least `maxComputeWorkGroupInvocations` of a device.
pub const GROUP_THREADS: u32 = 256;

/// The features a device must have; pass them to `vkCreateDevice` (API version 1.3).
pub struct Requirements {
    /// Core features.
    pub features: vk::PhysicalDeviceFeatures,
    /// Vulkan 1.2 features.
    pub vulkan12: vk::PhysicalDeviceVulkan12Features<'static>,
    /// Vulkan 1.3 features.
    pub vulkan13: vk::PhysicalDeviceVulkan13Features<'static>,
    /// What [`HostDevice::ray_query`] stands for, where the device has it; `vulkan12` then has `bufferDeviceAddress` on.
    pub ray_query: Option<RayQueryRequirements>,
}

/// Extensions and features for ray queries, by which [`crate::Config::exact`] is faster on devices that trace in hardware.
pub struct RayQueryRequirements {
    /// Device extensions.
    pub extensions: [&'static CStr; 3],
    /// Features of `VK_KHR_acceleration_structure`.
    pub acceleration_structure: vk::PhysicalDeviceAccelerationStructureFeaturesKHR<'static>,
    /// Features of `VK_KHR_ray_query`.
    pub ray_query: vk::PhysicalDeviceRayQueryFeaturesKHR<'static>,
}

/// What the device has of it.
///
/// # Safety
/// The handles must be valid.
unsafe fn ray_query_requirements(
    instance: &ash::Instance,
    physical_device: vk::PhysicalDevice,
) -> Option<RayQueryRequirements> {
    use ash::khr;
    let extensions = [khr::acceleration_structure::NAME, khr::ray_query::NAME, khr::deferred_host_operations::NAME];
    // SAFETY: the caller vouches for the handles
    let available = unsafe { instance.enumerate_device_extension_properties(physical_device) }.unwrap_or_default();
    let has = |name: &&CStr| available.iter().any(|e| e.extension_name_as_c_str() == Ok(*name));
    if !extensions.iter().all(has) {
        return None;
    }
    let mut structure = vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default();
    let mut query = vk::PhysicalDeviceRayQueryFeaturesKHR::default();
    let mut vulkan12 = vk::PhysicalDeviceVulkan12Features::default();
    let mut features =
        vk::PhysicalDeviceFeatures2::default().push_next(&mut structure).push_next(&mut query).push_next(&mut vulkan12);
    // SAFETY: as above; the extensions are there
    unsafe { instance.get_physical_device_features2(physical_device, &mut features) };
    let all = [structure.acceleration_structure, query.ray_query, vulkan12.buffer_device_address];
    (all == [vk::TRUE; 3]).then(|| RayQueryRequirements {
        extensions,
        acceleration_structure: vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default()
            .acceleration_structure(true),
        ray_query: vk::PhysicalDeviceRayQueryFeaturesKHR::default().ray_query(true),
    })
}

/// What the engine needs enabled on the device. `drawIndirectCount` and ray queries are used where the device has them.
///
/// # Safety
/// The handles must be valid.
pub unsafe fn requirements(instance: &ash::Instance, physical_device: vk::PhysicalDevice) -> Requirements {
    let mut vulkan12 = vk::PhysicalDeviceVulkan12Features::default();
    let mut available = vk::PhysicalDeviceFeatures2::default().push_next(&mut vulkan12);
    // SAFETY: the caller vouches for the handles
    unsafe { instance.get_physical_device_features2(physical_device, &mut available) };
    // SAFETY: as above
    let ray_query = unsafe { ray_query_requirements(instance, physical_device) };
    Requirements {
        features: vk::PhysicalDeviceFeatures::default().multi_draw_indirect(true).draw_indirect_first_instance(true),
        vulkan12: vk::PhysicalDeviceVulkan12Features::default()
            .shader_output_layer(true)
            .draw_indirect_count(vulkan12.draw_indirect_count == vk::TRUE)
            .buffer_device_address(ray_query.is_some()),
        vulkan13: vk::PhysicalDeviceVulkan13Features::default().dynamic_rendering(true).synchronization2(true),
        ray_query,
    }
}

/// What the physical device lacks, one phrase each; empty when the engine can run.
///
/// # Safety
/// The handles must be valid.
pub unsafe fn missing_features(instance: &ash::Instance, physical_device: vk::PhysicalDevice) -> Vec<String> {
    let mut missing = Vec::new();
    // SAFETY: the caller vouches for the handles
    let properties = unsafe { instance.get_physical_device_properties(physical_device) };
    if properties.api_version < vk::API_VERSION_1_3 {
        let (major, minor) =
            (vk::api_version_major(properties.api_version), vk::api_version_minor(properties.api_version));
        return vec![format!("Vulkan 1.3 is needed, the device offers {major}.{minor}")];
    }
    let mut vulkan12 = vk::PhysicalDeviceVulkan12Features::default();
    let mut vulkan13 = vk::PhysicalDeviceVulkan13Features::default();
    let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut vulkan12).push_next(&mut vulkan13);
    // SAFETY: as above
    unsafe { instance.get_physical_device_features2(physical_device, &mut features) };
    let core = features.features;
    for (present, name) in [
        (core.multi_draw_indirect, "multiDrawIndirect"),
        (core.draw_indirect_first_instance, "drawIndirectFirstInstance"),
        (vulkan12.shader_output_layer, "shaderOutputLayer"),
        (vulkan13.dynamic_rendering, "dynamicRendering"),
        (vulkan13.synchronization2, "synchronization2"),
    ] {
        if present == vk::FALSE {
            missing.push(format!("feature {name}"));
        }
    }
    let limits = properties.limits;
    for (value, needed, name) in [
        (limits.max_compute_work_group_invocations, GROUP_THREADS, "maxComputeWorkGroupInvocations"),
        (limits.max_compute_shared_memory_size, 16384, "maxComputeSharedMemorySize"),
        (limits.max_per_stage_descriptor_storage_buffers, STORAGE_BUFFERS, "maxPerStageDescriptorStorageBuffers"),
        (limits.max_image_array_layers, 256, "maxImageArrayLayers"),
        (limits.max_framebuffer_layers, 256, "maxFramebufferLayers"),
    ] {
        if value < needed {
            missing.push(format!("limit {name} is {value}, needed is {needed}"));
        }
    }
    missing
}

/// Embeds a shader of `spirv/` by its path without `.spv`.
macro_rules! spirv {
    ($path:literal) => {
        include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/spirv/", $path, ".spv")).as_slice()
    };
}
pub(crate) use spirv;
