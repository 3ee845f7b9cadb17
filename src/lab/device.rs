//! Instance, device and queue of the lab; what devices there are and what they lack.

use super::{LabError, LabOptions};
use crate::error::{Context, Error};
use crate::gpu::{self, Gpu, HostDevice};
use ash::vk;
use std::ffi::{CStr, c_char, c_void};
use std::sync::{Arc, Mutex};

/// A Vulkan device as `umbrage info` lists it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DeviceReport {
    /// Index for `--device`.
    pub index: usize,
    /// Name as the driver reports it.
    pub name: String,
    /// `discrete`, `integrated`, `virtual`, `cpu` or `other`.
    pub kind: &'static str,
    /// Vulkan version.
    pub api_version: String,
    /// Name and version of the driver.
    pub driver: String,
    /// What it lacks, one phrase each; empty when the engine can run on it.
    pub missing: Vec<String>,
    /// Optional things and whether they are there.
    pub notes: Vec<String>,
}

/// Owns the Vulkan objects; dropped after everything made from them.
pub(crate) struct LabDevice {
    pub(crate) report: DeviceReport,
    pub(crate) handles: HostDevice,
    /// Whether tessellation is enabled: wherever there is any.
    pub(crate) tessellation: bool,
    queue: vk::Queue,
    #[cfg_attr(not(feature = "window"), allow(dead_code))] // the window has a pool of its own
    family: u32,
    pool: vk::CommandPool,
    cmd: vk::CommandBuffer,
    fence: vk::Fence,
    owned: Arc<OwnedInstance>,
}

pub(crate) struct OwnedInstance {
    #[cfg_attr(not(feature = "window"), allow(dead_code))] // what loads functions must outlive them
    pub(crate) entry: ash::Entry,
    pub(crate) instance: ash::Instance,
    messenger: Option<(ash::ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    messages: Box<Mutex<Vec<String>>>,
}

/// What a device is presented on, where it is at all.
#[cfg_attr(not(feature = "window"), allow(dead_code))] // the window makes it
pub(crate) struct Present<'a> {
    /// Instance extensions of the window system.
    pub(crate) extensions: &'a [*const c_char],
    /// Makes the window's surface.
    pub(crate) surface: &'a dyn Fn(&ash::Entry, &ash::Instance) -> Result<vk::SurfaceKHR, LabError>,
}

/// A window's surface; destroyed before the instance.
#[cfg_attr(not(feature = "window"), allow(dead_code))] // the window makes it
pub(crate) struct Surface {
    pub(crate) raw: vk::SurfaceKHR,
    pub(crate) functions: ash::khr::surface::Instance,
    _owned: Arc<OwnedInstance>,
}

impl Surface {
    #[cfg(feature = "window")]
    pub(crate) fn new(owned: &Arc<OwnedInstance>, present: &Present<'_>) -> Result<Self, LabError> {
        let raw = (present.surface)(&owned.entry, &owned.instance)?;
        let functions = ash::khr::surface::Instance::new(&owned.entry, &owned.instance);
        Ok(Self { raw, functions, _owned: owned.clone() })
    }

    /// Whether a queue family can present on it.
    fn presents(&self, device: vk::PhysicalDevice, family: usize) -> bool {
        // SAFETY: device and surface belong to the instance; a device of other drivers than the surface's may fail
        unsafe { self.functions.get_physical_device_surface_support(device, family as u32, self.raw) }.unwrap_or(false)
    }
}

impl Drop for Surface {
    fn drop(&mut self) {
        // SAFETY: its swapchains are gone
        unsafe { self.functions.destroy_surface(self.raw, None) };
    }
}

impl Drop for OwnedInstance {
    fn drop(&mut self) {
        // SAFETY: everything made from the instance is gone
        unsafe {
            if let Some((utils, messenger)) = &self.messenger {
                utils.destroy_debug_utils_messenger(*messenger, None);
            }
            self.instance.destroy_instance(None);
        }
    }
}

impl Drop for LabDevice {
    fn drop(&mut self) {
        // SAFETY: all users hold this object alive, so nothing else of the device is left
        unsafe {
            let device = &self.handles.device;
            let _ = device.device_wait_idle();
            device.destroy_fence(self.fence, None);
            device.destroy_command_pool(self.pool, None);
            device.destroy_device(None);
        }
        let _ = &self.owned;
    }
}

const VALIDATION: &CStr = c"VK_LAYER_KHRONOS_validation";

unsafe extern "system" fn on_message(
    severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layer passes valid data; `user` is the mutex of the instance that owns this messenger
    let (text, messages) = unsafe {
        let text = (*data).message_as_c_str().map(|t| t.to_string_lossy().into_owned()).unwrap_or_default();
        (text, &*user.cast::<Mutex<Vec<String>>>())
    };
    if let Ok(mut messages) = messages.lock() {
        messages.push(format!("{severity:?}: {text}"));
    }
    vk::FALSE
}

impl OwnedInstance {
    fn new(validation: bool, present: Option<&Present<'_>>) -> Result<Self, LabError> {
        // SAFETY: loading the system's Vulkan loader
        let entry = unsafe { ash::Entry::load() }.map_err(|error| {
            LabError::Refused(format!(
                "no Vulkan loader was found ({error}); on Debian it is in the package libvulkan1"
            ))
        })?;
        // SAFETY: plain queries and create calls with complete infos
        unsafe {
            let extensions = entry.enumerate_instance_extension_properties(None).unwrap_or_default();
            let has = |name: &CStr| extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(name));
            let layers = entry.enumerate_instance_layer_properties().unwrap_or_default();
            let has_layer = layers.iter().any(|l| l.layer_name_as_c_str() == Ok(VALIDATION));
            if validation && !has_layer {
                let what = "validation was asked for but the layer VK_LAYER_KHRONOS_validation is missing; on Debian it is in the package vulkan-validationlayers";
                return Err(LabError::Refused(what.into()));
            }
            let app = vk::ApplicationInfo::default().application_name(c"umbrage").api_version(vk::API_VERSION_1_3);
            let mut names = present.map_or_else(Vec::new, |present| present.extensions.to_vec());
            for name in &names {
                let name = CStr::from_ptr(*name);
                if !has(name) {
                    let what =
                        format!("the Vulkan loader offers no window surfaces: it lacks {}", name.to_string_lossy());
                    return Err(LabError::Refused(what));
                }
            }
            let debug = validation;
            if debug {
                names.push(ash::ext::debug_utils::NAME.as_ptr());
            }
            let portability = has(ash::khr::portability_enumeration::NAME);
            if portability {
                names.push(ash::khr::portability_enumeration::NAME.as_ptr());
            }
            let layer_names: Vec<_> = if validation { vec![VALIDATION.as_ptr()] } else { Vec::new() };
            let enables = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
            let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enables);
            let mut info = vk::InstanceCreateInfo::default()
                .application_info(&app)
                .enabled_extension_names(&names)
                .enabled_layer_names(&layer_names);
            if portability {
                info = info.flags(vk::InstanceCreateFlags::ENUMERATE_PORTABILITY_KHR);
            }
            if validation {
                info = info.push_next(&mut features);
            }
            let instance = entry.create_instance(&info, None).context("vkCreateInstance")?;
            let mut owned = Self { entry, instance, messenger: None, messages: Box::default() };
            if debug {
                use vk::{DebugUtilsMessageSeverityFlagsEXT as S, DebugUtilsMessageTypeFlagsEXT as T};
                let utils = ash::ext::debug_utils::Instance::new(&owned.entry, &owned.instance);
                let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
                    .message_severity(S::ERROR | S::WARNING)
                    .message_type(T::VALIDATION | T::PERFORMANCE)
                    .pfn_user_callback(Some(on_message))
                    .user_data(std::ptr::from_ref::<Mutex<Vec<String>>>(&owned.messages).cast_mut().cast());
                let messenger =
                    utils.create_debug_utils_messenger(&info, None).context("vkCreateDebugUtilsMessengerEXT")?;
                owned.messenger = Some((utils, messenger));
            }
            Ok(owned)
        }
    }

    pub(crate) fn messages(&self) -> Vec<String> {
        self.messages.lock().map(|m| m.clone()).unwrap_or_default()
    }

    fn reports(&self) -> Result<Vec<(vk::PhysicalDevice, DeviceReport)>, LabError> {
        // SAFETY: the instance is alive
        let devices = unsafe { self.instance.enumerate_physical_devices() }.context("vkEnumeratePhysicalDevices")?;
        Ok(devices.into_iter().enumerate().map(|(index, device)| (device, self.report(index, device))).collect())
    }

    /// Why a device cannot show pictures on a surface.
    fn cannot_present(&self, device: vk::PhysicalDevice, surface: Option<&Surface>) -> Option<String> {
        // SAFETY: the physical device belongs to the instance
        let extensions = unsafe { self.instance.enumerate_device_extension_properties(device) }.unwrap_or_default();
        if !extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(ash::khr::swapchain::NAME)) {
            return Some("extension VK_KHR_swapchain".into());
        }
        family(&self.instance, device, surface).is_none().then(|| "a queue that presents on this window".into())
    }

    fn report(&self, index: usize, device: vk::PhysicalDevice) -> DeviceReport {
        let mut driver = vk::PhysicalDeviceDriverProperties::default();
        let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut driver);
        let mut vulkan12 = vk::PhysicalDeviceVulkan12Features::default();
        let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut vulkan12);
        // SAFETY: the physical device belongs to the instance
        let (missing, ray_query) = unsafe {
            self.instance.get_physical_device_properties2(device, &mut properties);
            self.instance.get_physical_device_features2(device, &mut features);
            let ray_query = gpu::requirements(&self.instance, device).ray_query.is_some();
            (gpu::missing_features(&self.instance, device), ray_query)
        };
        let p = properties.properties;
        let text = |t: Result<&CStr, _>| t.map(|t: &CStr| t.to_string_lossy().into_owned()).unwrap_or_default();
        let version =
            |v: u32| format!("{}.{}.{}", vk::api_version_major(v), vk::api_version_minor(v), vk::api_version_patch(v));
        let yes = |v: vk::Bool32| if v == vk::TRUE { "yes" } else { "no" };
        let layers = p.limits.max_image_array_layers.min(p.limits.max_framebuffer_layers);
        let driver = format!("{} {}", text(driver.driver_name_as_c_str()), text(driver.driver_info_as_c_str()));
        DeviceReport {
            index,
            name: text(p.device_name_as_c_str()),
            kind: match p.device_type {
                vk::PhysicalDeviceType::DISCRETE_GPU => "discrete",
                vk::PhysicalDeviceType::INTEGRATED_GPU => "integrated",
                vk::PhysicalDeviceType::VIRTUAL_GPU => "virtual",
                vk::PhysicalDeviceType::CPU => "cpu",
                _ => "other",
            },
            api_version: version(p.api_version),
            driver: driver.trim().to_owned(),
            missing,
            notes: vec![
                format!("drawIndirectCount: {}", yes(vulkan12.draw_indirect_count)),
                format!("ray queries: {}", yes(vk::Bool32::from(ray_query))),
                format!("pages of 128x128 texels: at most {layers} ({} MiB)", layers / 16),
                format!("largest conventional map: {0}x{0}", p.limits.max_image_dimension2_d),
            ],
        }
    }
}

/// All Vulkan devices of this machine.
///
/// # Errors
/// [`LabError::Refused`] when there is no Vulkan loader.
pub fn devices() -> Result<Vec<DeviceReport>, LabError> {
    Ok(OwnedInstance::new(false, None)?.reports()?.into_iter().map(|(_, report)| report).collect())
}

/// Opens the device that the options choose, or the best usable one: discrete before integrated before others.
pub(crate) fn open(options: &LabOptions) -> Result<(Arc<LabDevice>, Arc<Gpu>), LabError> {
    let owned = OwnedInstance::new(options.validation, None)?;
    open_on(options, Arc::new(owned), None)
}

#[cfg(feature = "window")]
/// The same with a surface that the device can present on.
pub(crate) fn open_presenting(
    options: &LabOptions,
    present: &Present<'_>,
) -> Result<(Arc<LabDevice>, Arc<Gpu>, Surface), LabError> {
    let owned = Arc::new(OwnedInstance::new(options.validation, Some(present))?);
    let surface = Surface::new(&owned, present)?;
    let (device, gpu) = open_on(options, owned, Some(&surface))?;
    Ok((device, gpu, surface))
}

/// The queue family that does everything.
fn family(instance: &ash::Instance, device: vk::PhysicalDevice, surface: Option<&Surface>) -> Option<usize> {
    // SAFETY: the physical device belongs to the instance
    let families = unsafe { instance.get_physical_device_queue_family_properties(device) };
    let wanted = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
    let fits = |f: &vk::QueueFamilyProperties| f.queue_flags.contains(wanted) && f.timestamp_valid_bits > 0;
    (0..families.len()).find(|&i| fits(&families[i]) && surface.is_none_or(|surface| surface.presents(device, i)))
}

fn open_on(
    options: &LabOptions,
    owned: Arc<OwnedInstance>,
    surface: Option<&Surface>,
) -> Result<(Arc<LabDevice>, Arc<Gpu>), LabError> {
    let mut reports = owned.reports()?;
    if surface.is_some() {
        reports.iter_mut().for_each(|(device, report)| report.missing.extend(owned.cannot_present(*device, surface)));
    }
    let rank = |kind| ["discrete", "integrated", "virtual", "other", "cpu"].iter().position(|k| *k == kind);
    let (physical_device, report) = match options.device {
        Some(index) => reports.get(index).cloned().ok_or_else(|| {
            LabError::Usage(format!(
                "--device {index} does not exist; there are {} Vulkan devices, numbered from 0",
                reports.len()
            ))
        })?,
        None => {
            reports.iter().filter(|(_, r)| r.missing.is_empty()).min_by_key(|(_, r)| rank(r.kind)).cloned().ok_or_else(
                || {
                    let place = if surface.is_some() { " with this window" } else { "" };
                    LabError::Refused(format!(
                        "none of the {} Vulkan devices is usable{place}; `umbrage info` says what each lacks",
                        reports.len()
                    ))
                },
            )?
        }
    };
    if let Some(what) = report.missing.first() {
        return Err(LabError::Refused(format!("device {} ({}) lacks {what}", report.index, report.name)));
    }
    let instance = owned.instance.clone();
    // SAFETY: the handles are alive; infos are complete; on failure nothing but the instance is left, which `owned` frees
    let device = unsafe {
        let family = family(&instance, physical_device, surface)
            .ok_or_else(|| Error::Unsupported { what: "no queue offers graphics, compute and timestamps".into() })?
            as u32;
        let mut needs = gpu::requirements(&instance, physical_device);
        let tessellation = instance.get_physical_device_features(physical_device).tessellation_shader;
        needs.features.tessellation_shader = tessellation;
        let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&[1.0])];
        let mut extensions: Vec<*const c_char> = Vec::new();
        if surface.is_some() {
            extensions.push(ash::khr::swapchain::NAME.as_ptr());
        }
        let mut info = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .enabled_features(&needs.features)
            .push_next(&mut needs.vulkan12)
            .push_next(&mut needs.vulkan13);
        let ray_query = needs.ray_query.is_some();
        if let Some(rays) = &mut needs.ray_query {
            extensions.extend(rays.extensions.map(CStr::as_ptr));
            info = info.push_next(&mut rays.acceleration_structure).push_next(&mut rays.ray_query);
        }
        let info = info.enabled_extension_names(&extensions);
        let device = instance.create_device(physical_device, &info, None).context("vkCreateDevice")?;
        let queue = device.get_device_queue(family, 0);
        let mut lab = LabDevice {
            report,
            handles: HostDevice {
                instance,
                physical_device,
                device,
                debug_utils: owned.messenger.is_some(),
                ray_query,
            },
            tessellation: tessellation == vk::TRUE,
            queue,
            family,
            pool: vk::CommandPool::null(),
            cmd: vk::CommandBuffer::null(),
            fence: vk::Fence::null(),
            owned,
        };
        let device = &lab.handles.device;
        let info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(family)
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
        lab.pool = device.create_command_pool(&info, None).context("vkCreateCommandPool")?;
        let info = vk::CommandBufferAllocateInfo::default().command_pool(lab.pool).command_buffer_count(1);
        lab.cmd = device.allocate_command_buffers(&info).context("vkAllocateCommandBuffers")?[0];
        lab.fence = device.create_fence(&vk::FenceCreateInfo::default(), None).context("vkCreateFence")?;
        Arc::new(lab)
    };
    // SAFETY: `Gpu` keeps the device alive through its owner
    let gpu = unsafe { Gpu::owned(&device.handles, Some(device.clone()))? };
    Ok((device, gpu))
}

impl LabDevice {
    #[cfg(feature = "window")]
    pub(crate) fn queue(&self) -> vk::Queue {
        self.queue
    }

    #[cfg(feature = "window")]
    pub(crate) fn family(&self) -> u32 {
        self.family
    }

    #[cfg(feature = "window")]
    pub(crate) fn instance(&self) -> &Arc<OwnedInstance> {
        &self.owned
    }

    pub(crate) fn messages(&self) -> Vec<String> {
        self.owned.messages()
    }

    /// The lab's command buffer, recording. There is one; submissions are waited for.
    pub(crate) fn begin(&self) -> Result<vk::CommandBuffer, Error> {
        let info = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the last submission of this command buffer was waited for
        unsafe { self.handles.device.begin_command_buffer(self.cmd, &info) }.context("vkBeginCommandBuffer")?;
        Ok(self.cmd)
    }

    pub(crate) fn submit_and_wait(&self, cmd: vk::CommandBuffer) -> Result<(), Error> {
        let device = &self.handles.device;
        // SAFETY: the command buffer was begun by `begin`
        unsafe {
            device.end_command_buffer(cmd).context("vkEndCommandBuffer")?;
            device.reset_fences(&[self.fence]).context("vkResetFences")?;
            let commands = [vk::CommandBufferSubmitInfo::default().command_buffer(cmd)];
            let submit = [vk::SubmitInfo2::default().command_buffer_infos(&commands)];
            device.queue_submit2(self.queue, &submit, self.fence).context("vkQueueSubmit2")?;
            device.wait_for_fences(&[self.fence], true, u64::MAX).context("vkWaitForFences")
        }
    }
}
