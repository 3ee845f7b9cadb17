//! Every Vulkan call that makes something fails in turn while an engine is made: the error says so, nothing is left, and
//! nothing of the host's is touched. Calls go through a table of functions that count what is alive.

use super::host::example;
use ash::vk;
use std::ffi::{CStr, c_void};
use std::mem::transmute;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicI64, AtomicU64, Ordering::SeqCst};
use umbrage::scene::builtin;
use umbrage::{CastPolicy, Config, Engine, Error, Filter, HostDevice, ImageUse, Receivers, RequestRoute};

/// Calls so far, the one that fails, and how many objects are alive.
static CALLS: AtomicU64 = AtomicU64::new(0);
static FAILS: AtomicU64 = AtomicU64::new(u64::MAX);
static ALIVE: AtomicI64 = AtomicI64::new(0);
/// Handles of pipelines, which are not made: that would take long and nothing runs.
static NEXT: AtomicU64 = AtomicU64::new(1);

/// Whether this call is the one that fails.
fn fails() -> bool {
    CALLS.fetch_add(1, SeqCst) == FAILS.load(SeqCst)
}

/// Functions that make one thing, and those that destroy it.
macro_rules! counted {
    ($($make:ident $make_name:literal $info:ty, $destroy:ident $destroy_name:literal $handle:ty;)*) => {
        $(
            mod $make {
                pub static MAKE: super::OnceLock<usize> = super::OnceLock::new();
                pub static DESTROY: super::OnceLock<usize> = super::OnceLock::new();
            }
            unsafe extern "system" fn $make(
                device: vk::Device,
                info: *const $info,
                callbacks: *const vk::AllocationCallbacks<'_>,
                handle: *mut $handle,
            ) -> vk::Result {
                if fails() {
                    return vk::Result::ERROR_OUT_OF_DEVICE_MEMORY;
                }
                type F<'a> = unsafe extern "system" fn(
                    vk::Device, *const $info, *const vk::AllocationCallbacks<'a>, *mut $handle,
                ) -> vk::Result;
                // SAFETY: what the driver gave for this name, called as the engine called it
                let result = unsafe { transmute::<usize, F<'_>>(*$make::MAKE.get().unwrap())(device, info, callbacks, handle) };
                ALIVE.fetch_add(i64::from(result == vk::Result::SUCCESS), SeqCst);
                result
            }
            unsafe extern "system" fn $destroy(
                device: vk::Device,
                handle: $handle,
                callbacks: *const vk::AllocationCallbacks<'_>,
            ) {
                type F<'a> = unsafe extern "system" fn(vk::Device, $handle, *const vk::AllocationCallbacks<'a>);
                ALIVE.fetch_sub(i64::from(handle != <$handle>::null()), SeqCst);
                // SAFETY: as above
                unsafe { transmute::<usize, F<'_>>(*$make::DESTROY.get().unwrap())(device, handle, callbacks) }
            }
        )*
        /// The engine's functions: those above, and the driver's for the rest.
        fn load(name: &CStr, driver: *const c_void) -> *const c_void {
            match name.to_bytes() {
                $(
                    $make_name => {
                        $make::MAKE.get_or_init(|| driver as usize);
                        $make as *const c_void
                    }
                    $destroy_name => {
                        $make::DESTROY.get_or_init(|| driver as usize);
                        $destroy as *const c_void
                    }
                )*
                b"vkCreateComputePipelines" => compute_pipelines as *const c_void,
                b"vkCreateGraphicsPipelines" => graphics_pipelines as *const c_void,
                b"vkDestroyPipeline" => destroy_pipeline as *const c_void,
                _ => driver,
            }
        }
    };
}

counted! {
    allocate_memory b"vkAllocateMemory" vk::MemoryAllocateInfo<'_>, free_memory b"vkFreeMemory" vk::DeviceMemory;
    create_buffer b"vkCreateBuffer" vk::BufferCreateInfo<'_>, destroy_buffer b"vkDestroyBuffer" vk::Buffer;
    create_image b"vkCreateImage" vk::ImageCreateInfo<'_>, destroy_image b"vkDestroyImage" vk::Image;
    create_view b"vkCreateImageView" vk::ImageViewCreateInfo<'_>, destroy_view b"vkDestroyImageView" vk::ImageView;
    create_module b"vkCreateShaderModule" vk::ShaderModuleCreateInfo<'_>,
        destroy_module b"vkDestroyShaderModule" vk::ShaderModule;
    create_set_layout b"vkCreateDescriptorSetLayout" vk::DescriptorSetLayoutCreateInfo<'_>,
        destroy_set_layout b"vkDestroyDescriptorSetLayout" vk::DescriptorSetLayout;
    create_layout b"vkCreatePipelineLayout" vk::PipelineLayoutCreateInfo<'_>,
        destroy_layout b"vkDestroyPipelineLayout" vk::PipelineLayout;
    create_sampler b"vkCreateSampler" vk::SamplerCreateInfo<'_>, destroy_sampler b"vkDestroySampler" vk::Sampler;
    create_pool b"vkCreateDescriptorPool" vk::DescriptorPoolCreateInfo<'_>,
        destroy_pool b"vkDestroyDescriptorPool" vk::DescriptorPool;
}

fn pipelines(count: u32, handles: *mut vk::Pipeline) -> vk::Result {
    for i in 0..count as usize {
        if fails() {
            return vk::Result::ERROR_OUT_OF_DEVICE_MEMORY;
        }
        ALIVE.fetch_add(1, SeqCst);
        // SAFETY: the caller has room for so many
        unsafe { handles.add(i).write(vk::Handle::from_raw(NEXT.fetch_add(1, SeqCst))) };
    }
    vk::Result::SUCCESS
}

unsafe extern "system" fn compute_pipelines(
    _: vk::Device,
    _: vk::PipelineCache,
    count: u32,
    _: *const vk::ComputePipelineCreateInfo<'_>,
    _: *const vk::AllocationCallbacks<'_>,
    handles: *mut vk::Pipeline,
) -> vk::Result {
    pipelines(count, handles)
}

unsafe extern "system" fn graphics_pipelines(
    _: vk::Device,
    _: vk::PipelineCache,
    count: u32,
    _: *const vk::GraphicsPipelineCreateInfo<'_>,
    _: *const vk::AllocationCallbacks<'_>,
    handles: *mut vk::Pipeline,
) -> vk::Result {
    pipelines(count, handles)
}

unsafe extern "system" fn destroy_pipeline(_: vk::Device, handle: vk::Pipeline, _: *const vk::AllocationCallbacks<'_>) {
    ALIVE.fetch_sub(i64::from(handle != vk::Pipeline::null()), SeqCst);
}

#[test]
fn whatever_fails_while_an_engine_is_made_leaves_nothing() {
    let vulkan = example::Vulkan::new(false).unwrap();
    let scene = example::opaque(builtin());
    let bent = example::Bent { winds: &[0.0], policy: CastPolicy::Auto, tessellated: false };
    // casters that the engine draws, and those that the host does
    let contents = [None, Some(&bent)].map(|bent| example::Content::new(&vulkan, &scene, bent).unwrap());
    let own = &vulkan.host;
    // SAFETY: the handles are those of a living device
    let device = unsafe {
        let handle = own.device.handle();
        let driver = |name: &CStr| own.instance.get_device_proc_addr(handle, name.as_ptr());
        ash::Device::load_with(|name| load(name, driver(name).map_or(std::ptr::null(), |f| f as *const c_void)), handle)
    };
    let host = HostDevice { device, ..own.clone() };
    let base = Config { index_capacity: 1 << 20, ..Config::new(example::SIZE) };
    let configs = [
        Config { exact: true, samples: 4, ..base.clone() },
        Config { route: RequestRoute::Sort, filter: Filter::Pcf { taps: 4 }, gutter: 4, ..base },
    ];
    for (config, content) in configs.iter().zip(&contents) {
        let images = content.images(true);
        let views = [Receivers { size: example::SIZE, images: &images, mask: ImageUse::SAMPLED }];
        let make = |fails: u64| {
            CALLS.store(0, SeqCst);
            FAILS.store(fails, SeqCst);
            // SAFETY: the handles are alive; nothing is recorded
            unsafe { Engine::new(&host, config, &content.buffers, &views) }
        };
        let engine = make(u64::MAX).unwrap();
        let calls = CALLS.load(SeqCst);
        let alive = ALIVE.load(SeqCst);
        drop(engine);
        assert!(calls > 200 && alive > 100, "{calls} calls, {alive} things");
        assert_eq!(ALIVE.load(SeqCst), 0, "left by an engine that was made");
        for call in 0..calls {
            match make(call).map(drop) {
                Err(Error::OutOfMemory { .. } | Error::Vulkan { .. }) => {}
                other => panic!("call {call} of {calls} fails: {other:?}"),
            }
            assert_eq!(ALIVE.load(SeqCst), 0, "left after call {call} of {calls} failed");
        }
        println!("{calls} calls, {alive} things");
    }
}
