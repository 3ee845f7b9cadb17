//! What recording a frame costs the CPU: no allocation, and the same whatever the atlas holds.
#![cfg(feature = "lab")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::time::Instant;
use umbrage::scene::{Instance, Scene, builtin};
use umbrage::{Config, Engine, FrameInput, ImageUse, Light, Receivers};

#[path = "../examples/host.rs"]
#[allow(dead_code)]
mod example;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: the system's allocator does the work
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
        // SAFETY: as the caller vouches
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        // SAFETY: as the caller vouches
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// The built-in scene with as many more instances of its last mesh as make `count` casters.
fn crowd(count: u32) -> Scene {
    let mut scene = example::opaque(builtin());
    let clusters: u32 = scene.instances.iter().map(|i| scene.meshes[i.mesh as usize].cluster_count).sum();
    let last = scene.meshes.len() - 1;
    let more = (count - clusters).div_ceil(scene.meshes[last].cluster_count);
    let copy: Instance = scene.instances[scene.instances.len() - 1];
    scene.instances.extend((0..more).map(|_| copy));
    scene.meshes[last].instance_count += more;
    scene
}

#[test]
fn a_frame_is_recorded_without_allocating() {
    let vulkan = example::Vulkan::new(false).unwrap();
    let scene = crowd(10_000);
    let content = example::Content::new(&vulkan, &scene, None).unwrap();
    assert!((10_000..10_100).contains(&content.buffers.caster_count), "{} casters", content.buffers.caster_count);
    let images = content.images(true);
    let views = [Receivers { size: example::SIZE, images: &images, mask: ImageUse::SAMPLED }];
    let (camera, sun) = example::look(&scene);
    for (atlas_mib, lights) in [(2, 1), (64, 1), (64, 20)] {
        let config = Config {
            index_capacity: 1 << 20,
            atlas_bytes: atlas_mib << 20,
            lights,
            mask_bits: 8,
            ..Config::new(example::SIZE)
        };
        // SAFETY: the device has what is required, and everything outlives the engine
        let mut engine = unsafe { Engine::new(&vulkan.host, &config, &content.buffers, &views) }.unwrap();
        engine.add_light(&sun).unwrap();
        for i in 1..lights {
            let position = scene.origin + glam::DVec3::splat(f64::from(i) * 0.1);
            engine.add_light(&Light::Point { position, range: 5.0 }).unwrap();
        }
        let input = FrameInput::new(&camera, example::SIZE, scene.origin);
        let mut times = Vec::with_capacity(64);
        for _ in 0..64 {
            vulkan
                .record(|cmd| {
                    let (before, start) = (ALLOCATIONS.get(), Instant::now());
                    // SAFETY: recording; nothing is ever submitted
                    let recorded = unsafe { engine.record(cmd, std::slice::from_ref(&input)) };
                    times.push(start.elapsed().as_secs_f64() * 1e3);
                    assert_eq!(ALLOCATIONS.get() - before, 0, "allocations, {atlas_mib} MiB, {lights} lights");
                    recorded.unwrap();
                })
                .unwrap();
        }
        times.sort_by(f64::total_cmp);
        println!("{atlas_mib} MiB, {lights} lights: record takes {:.3} ms (median of {})", times[32], times.len());
    }
}
