//! The host's device, and what must be enabled on it.

use super::guard::{Failure, UMBRAGE_ERROR_UNSUPPORTED, UmbrageResult, guard};
use super::input::{mutable, output, present, sized};
use super::vulkan::*;
use crate::{HostDevice, missing_features, requirements};
use ash::vk::{self, StructureType};
use std::ffi::{CStr, c_char};
use std::mem::offset_of;

/// Handles that the host made and keeps alive as long as any engine made from them.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct UmbrageDevice {
    /// sizeof(UmbrageDevice).
    pub struct_size: usize,
    /// The loader's vkGetInstanceProcAddr; all other functions are found through it.
    pub get_instance_proc_addr: PFN_vkGetInstanceProcAddr,
    /// Made with API version 1.3.
    pub instance: VkInstance,
    /// The physical device.
    pub physical_device: VkPhysicalDevice,
    /// The logical device. The functions that come before there is one do not look at it.
    pub device: VkDevice,
    /// Whether VK_EXT_debug_utils is enabled on the instance, so that passes and objects get names.
    pub debug_utils: VkBool32,
    /// Whether what umbrage_enable_ray_queries names is enabled on the device.
    pub ray_query: VkBool32,
}

#[cfg(target_pointer_width = "64")]
const _: () = assert!(size_of::<UmbrageDevice>() == 5 * 8 + 2 * 4);

/// An instance and a physical device that are there.
struct Physical {
    instance: ash::Instance,
    physical_device: VkPhysicalDevice,
    given: UmbrageDevice,
}

fn unsupported(text: impl Into<String>) -> Failure {
    Failure { code: UMBRAGE_ERROR_UNSUPPORTED, text: text.into() }
}

/// # Safety
/// Null, or valid handles but for `device`.
unsafe fn physical(device: *const UmbrageDevice) -> Result<Physical, Failure> {
    let empty = UmbrageDevice {
        struct_size: 0,
        get_instance_proc_addr: None,
        instance: VkInstance::null(),
        physical_device: VkPhysicalDevice::null(),
        device: VkDevice::null(),
        debug_utils: 0,
        ray_query: 0,
    };
    // SAFETY: the caller vouches for the pointer
    let given = unsafe { sized(device, empty, size_of::<UmbrageDevice>(), "the device")? };
    let get = given.get_instance_proc_addr.ok_or_else(|| Failure::argument("get_instance_proc_addr is null"))?;
    present(given.instance, "the instance")?;
    present(given.physical_device, "the physical device")?;
    // SAFETY: the caller vouches for the handles
    unsafe {
        // a function that is not there would end the process when it is called
        if get(given.instance, c"vkGetPhysicalDeviceFeatures2".as_ptr()).is_none() {
            return Err(unsupported("the instance was not made with Vulkan 1.3"));
        }
        let functions = ash::StaticFn { get_instance_proc_addr: get };
        let instance = ash::Instance::load(&functions, given.instance);
        Ok(Physical { instance, physical_device: given.physical_device, given })
    }
}

impl UmbrageDevice {
    /// # Safety
    /// Null, or valid handles.
    pub(super) unsafe fn read(device: *const Self) -> Result<HostDevice, Failure> {
        // SAFETY: the caller vouches for the handles
        let Physical { instance, physical_device, given } = unsafe { physical(device)? };
        present(given.device, "the device's handle")?;
        let functions = [
            (c"vkCmdPipelineBarrier2", true, "Vulkan 1.3"),
            (c"vkCmdBeginRendering", true, "Vulkan 1.3"),
            (c"vkCreateAccelerationStructureKHR", given.ray_query != 0, "the extensions for ray queries"),
        ];
        for (name, needed, what) in functions {
            // SAFETY: as above
            if needed && unsafe { instance.get_device_proc_addr(given.device, name.as_ptr()) }.is_none() {
                let name = name.to_string_lossy();
                return Err(unsupported(format!("the device was not made with {what}: it has no {name}")));
            }
        }
        // SAFETY: as above
        let device = unsafe { ash::Device::load(instance.fp_v1_0(), given.device) };
        let debug_utils = given.debug_utils != 0;
        Ok(HostDevice { instance, physical_device, device, debug_utils, ray_query: given.ray_query != 0 })
    }
}

fn tagged(given: StructureType, want: StructureType, what: &str) -> Result<(), Failure> {
    if given == want {
        return Ok(());
    }
    Err(Failure::limit("sType", format!("{} in {what}", given.as_raw()), format!("{}", want.as_raw())))
}

/// Switches on what `needed` has on.
///
/// # Safety
/// From the offset `first` to the offset `last` there are `VkBool32` fields alone.
unsafe fn switch_on<T>(host: &mut T, needed: &T, first: usize, last: usize) {
    let (to, from) = ((&raw mut *host).cast::<u8>(), (&raw const *needed).cast::<u8>());
    for at in (first..=last).step_by(size_of::<VkBool32>()) {
        // SAFETY: a field of the structs, as the caller says
        unsafe { *to.add(at).cast::<VkBool32>() |= *from.add(at).cast::<VkBool32>() };
    }
}

/// Whether the engine can run on a physical device; before there is a device. Otherwise UMBRAGE_ERROR_UNSUPPORTED, and
/// the message names everything that is missing, one phrase a line.
///
/// # Safety
/// device: valid handles; its device may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_check_device(device: *const UmbrageDevice) -> UmbrageResult {
    guard(|| {
        // SAFETY: the caller vouches for the handles
        let missing = unsafe {
            let physical = physical(device)?;
            missing_features(&physical.instance, physical.physical_device)
        };
        if missing.is_empty() { Ok(()) } else { Err(unsupported(missing.join("\n"))) }
    })
}

/// Switches on what the engine needs in the structs that the host passes to vkCreateDevice (API version 1.3), and what
/// it uses where the device has it. Everything else in them stays as it is, so their sType must be set before.
///
/// # Safety
/// device: valid handles; its device may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_enable_features(
    device: *const UmbrageDevice,
    features: *mut VkPhysicalDeviceFeatures,
    vulkan12: *mut VkPhysicalDeviceVulkan12Features,
    vulkan13: *mut VkPhysicalDeviceVulkan13Features,
) -> UmbrageResult {
    guard(|| {
        // SAFETY: the caller vouches for the pointers
        let (features, vulkan12, vulkan13) =
            unsafe { (mutable(features, "features")?, mutable(vulkan12, "vulkan12")?, mutable(vulkan13, "vulkan13")?) };
        tagged(vulkan12.s_type, StructureType::PHYSICAL_DEVICE_VULKAN_1_2_FEATURES, "vulkan12")?;
        tagged(vulkan13.s_type, StructureType::PHYSICAL_DEVICE_VULKAN_1_3_FEATURES, "vulkan13")?;
        // SAFETY: the caller vouches for the handles
        let needs = unsafe {
            let physical = physical(device)?;
            requirements(&physical.instance, physical.physical_device)
        };
        // with `umbrage_enable_ray_queries` only
        let needed12 = VkPhysicalDeviceVulkan12Features { buffer_device_address: vk::FALSE, ..needs.vulkan12 };
        use VkPhysicalDeviceFeatures as Core;
        use VkPhysicalDeviceVulkan12Features as V12;
        use VkPhysicalDeviceVulkan13Features as V13;
        // SAFETY: from the first feature to the last these structs have nothing but switches
        unsafe {
            let (first, last) = (offset_of!(Core, robust_buffer_access), offset_of!(Core, inherited_queries));
            switch_on(features, &needs.features, first, last);
            let (first, last) =
                (offset_of!(V12, sampler_mirror_clamp_to_edge), offset_of!(V12, subgroup_broadcast_dynamic_id));
            switch_on(vulkan12, &needed12, first, last);
            let (first, last) = (offset_of!(V13, robust_image_access), offset_of!(V13, maintenance4));
            switch_on(vulkan13, &needs.vulkan13, first, last);
        }
        Ok(())
    })
}

/// Switches on what ray queries need, by which exact shadows are faster on devices that trace in hardware, and hands
/// out the names of the device extensions (an array that lives for ever). UMBRAGE_ERROR_UNSUPPORTED where the device
/// has none. The structs go to vkCreateDevice; their sType must be set before.
///
/// # Safety
/// device: valid handles; its device may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_enable_ray_queries(
    device: *const UmbrageDevice,
    vulkan12: *mut VkPhysicalDeviceVulkan12Features,
    acceleration_structure: *mut VkPhysicalDeviceAccelerationStructureFeaturesKHR,
    ray_query: *mut VkPhysicalDeviceRayQueryFeaturesKHR,
    extensions: *mut *const *const c_char,
    extension_count: *mut u32,
) -> UmbrageResult {
    guard(|| {
        // SAFETY: the caller vouches for the pointers
        let (vulkan12, structure, query) = unsafe {
            (
                mutable(vulkan12, "vulkan12")?,
                mutable(acceleration_structure, "acceleration_structure")?,
                mutable(ray_query, "ray_query")?,
            )
        };
        // SAFETY: as above
        let (names, count) =
            unsafe { (output(extensions, "extensions")?, output(extension_count, "extension_count")?) };
        tagged(vulkan12.s_type, StructureType::PHYSICAL_DEVICE_VULKAN_1_2_FEATURES, "vulkan12")?;
        let wanted = StructureType::PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR;
        tagged(structure.s_type, wanted, "acceleration_structure")?;
        tagged(query.s_type, StructureType::PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR, "ray_query")?;
        // SAFETY: the caller vouches for the handles
        let needs = unsafe {
            let physical = physical(device)?;
            requirements(&physical.instance, physical.physical_device)
        };
        let needs = needs.ray_query.ok_or_else(|| unsupported("ray queries: the device has none"))?;
        structure.acceleration_structure |= needs.acceleration_structure.acceleration_structure;
        query.ray_query |= needs.ray_query.ray_query;
        vulkan12.buffer_device_address = vk::TRUE;
        if needs.extensions != EXTENSIONS {
            return Err(unsupported("ray queries: their extensions are others"));
        }
        names.write(POINTERS.0.as_ptr());
        count.write(EXTENSIONS.len() as u32);
        Ok(())
    })
}

const EXTENSIONS: [&CStr; 3] =
    [ash::khr::acceleration_structure::NAME, ash::khr::ray_query::NAME, ash::khr::deferred_host_operations::NAME];

struct Pointers([*const c_char; 3]);
// SAFETY: they point to constants
unsafe impl Sync for Pointers {}
static POINTERS: Pointers = Pointers([EXTENSIONS[0].as_ptr(), EXTENSIONS[1].as_ptr(), EXTENSIONS[2].as_ptr()]);
