//! Devices that lack something: refused by its name before anything is made. A real device, asked through functions that
//! leave something out.

use super::host::example;
use ash::vk;
use std::ffi::{CStr, c_char, c_void};
use std::mem::transmute;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
use umbrage::{Engine, Error, HostDevice, ImageUse, Receivers};

/// What is left out: an index into `LACKS`, or none.
static LACKING: AtomicUsize = AtomicUsize::new(usize::MAX);
static FEATURES: OnceLock<usize> = OnceLock::new();
static PROPERTIES: OnceLock<usize> = OnceLock::new();

enum Lack {
    Core(fn(&mut vk::PhysicalDeviceFeatures)),
    Vulkan12(fn(&mut vk::PhysicalDeviceVulkan12Features<'_>)),
    Vulkan13(fn(&mut vk::PhysicalDeviceVulkan13Features<'_>)),
    Property(fn(&mut vk::PhysicalDeviceProperties)),
}

const LACKS: [(&str, Lack); 11] = [
    ("feature multiDrawIndirect", Lack::Core(|f| f.multi_draw_indirect = vk::FALSE)),
    ("feature drawIndirectFirstInstance", Lack::Core(|f| f.draw_indirect_first_instance = vk::FALSE)),
    ("feature shaderOutputLayer", Lack::Vulkan12(|f| f.shader_output_layer = vk::FALSE)),
    ("feature dynamicRendering", Lack::Vulkan13(|f| f.dynamic_rendering = vk::FALSE)),
    ("feature synchronization2", Lack::Vulkan13(|f| f.synchronization2 = vk::FALSE)),
    (
        "limit maxComputeWorkGroupInvocations is 128, needed is 256",
        Lack::Property(|p| p.limits.max_compute_work_group_invocations = 128),
    ),
    (
        "limit maxComputeSharedMemorySize is 8192, needed is 16384",
        Lack::Property(|p| p.limits.max_compute_shared_memory_size = 8192),
    ),
    (
        "limit maxPerStageDescriptorStorageBuffers is 4, needed is 13",
        Lack::Property(|p| p.limits.max_per_stage_descriptor_storage_buffers = 4),
    ),
    ("limit maxImageArrayLayers is 255, needed is 256", Lack::Property(|p| p.limits.max_image_array_layers = 255)),
    ("limit maxFramebufferLayers is 255, needed is 256", Lack::Property(|p| p.limits.max_framebuffer_layers = 255)),
    (
        "Vulkan 1.3 is needed, the device offers 1.2",
        Lack::Property(|p| p.api_version = vk::make_api_version(0, 1, 2, 200)),
    ),
];

unsafe extern "system" fn features2(device: vk::PhysicalDevice, features: *mut vk::PhysicalDeviceFeatures2<'_>) {
    type F = unsafe extern "system" fn(vk::PhysicalDevice, *mut c_void);
    // SAFETY: the driver's function of this name, called as it was; the chain is that of the caller
    unsafe {
        transmute::<usize, F>(*FEATURES.get().unwrap())(device, features.cast());
        let Some((_, lack)) = LACKS.get(LACKING.load(SeqCst)) else { return };
        let mut next = features.cast::<vk::BaseOutStructure<'_>>();
        while !next.is_null() {
            match ((*next).s_type, lack) {
                (vk::StructureType::PHYSICAL_DEVICE_FEATURES_2, Lack::Core(cut)) => cut(&mut (*features).features),
                (vk::StructureType::PHYSICAL_DEVICE_VULKAN_1_2_FEATURES, Lack::Vulkan12(cut)) => cut(&mut *next.cast()),
                (vk::StructureType::PHYSICAL_DEVICE_VULKAN_1_3_FEATURES, Lack::Vulkan13(cut)) => cut(&mut *next.cast()),
                _ => {}
            }
            next = (*next).p_next;
        }
    }
}

unsafe extern "system" fn properties(device: vk::PhysicalDevice, properties: *mut vk::PhysicalDeviceProperties) {
    type F = unsafe extern "system" fn(vk::PhysicalDevice, *mut vk::PhysicalDeviceProperties);
    // SAFETY: as above
    unsafe {
        transmute::<usize, F>(*PROPERTIES.get().unwrap())(device, properties);
        if let Some((_, Lack::Property(cut))) = LACKS.get(LACKING.load(SeqCst)) {
            cut(&mut *properties);
        }
    }
}

fn load(name: &CStr, driver: Option<unsafe extern "system" fn()>) -> *const c_void {
    let driver = driver.map_or(std::ptr::null(), |f| f as *const c_void);
    match name.to_bytes() {
        b"vkGetPhysicalDeviceFeatures2" => {
            FEATURES.get_or_init(|| driver as usize);
            features2 as *const c_void
        }
        b"vkGetPhysicalDeviceProperties" => {
            PROPERTIES.get_or_init(|| driver as usize);
            properties as *const c_void
        }
        _ => driver,
    }
}

#[test]
fn a_device_that_lacks_something_is_refused_by_its_name() {
    let vulkan = example::Vulkan::new(false).unwrap();
    let scene = example::opaque(umbrage::scene::builtin());
    let content = example::Content::new(&vulkan, &scene, None).unwrap();
    let images = content.images(true);
    let views = [Receivers { size: example::SIZE, images: &images, mask: ImageUse::SAMPLED }];
    let config = umbrage::Config { index_capacity: 1 << 20, ..umbrage::Config::new(example::SIZE) };
    let own = &vulkan.host;
    // SAFETY: the loader's own functions, and handles of a living instance
    let instance = unsafe {
        let entry = ash::Entry::load().unwrap();
        let handle = own.instance.handle();
        let driver = |name: &CStr| entry.get_instance_proc_addr(handle, name.as_ptr().cast::<c_char>());
        ash::Instance::load_with(|name| load(name, driver(name)), handle)
    };
    // SAFETY: as above
    assert!(unsafe { umbrage::missing_features(&instance, own.physical_device) }.is_empty(), "the device as it is");
    let host = HostDevice { instance: instance.clone(), ..own.clone() };
    for (i, (phrase, _)) in LACKS.iter().enumerate() {
        LACKING.store(i, SeqCst);
        // SAFETY: as above
        let missing = unsafe { umbrage::missing_features(&instance, own.physical_device) };
        assert_eq!(missing, [phrase.to_string()]);
        // SAFETY: as above
        match unsafe { Engine::new(&host, &config, &content.buffers, &views) }.map(drop) {
            Err(error @ Error::Unsupported { .. }) => assert_eq!(error.to_string(), format!("unsupported: {phrase}")),
            other => panic!("{phrase}: {other:?}"),
        }
    }
    LACKING.store(usize::MAX, SeqCst);
    // SAFETY: as above
    assert!(unsafe { Engine::new(&host, &config, &content.buffers, &views) }.is_ok());
}
