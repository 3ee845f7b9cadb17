//! The engine: made, given lights, recorded, asked, destroyed.

use super::config::UmbrageConfig;
use super::device::UmbrageDevice;
use super::guard::{Failure, Guarded, UmbrageResult, guard};
use super::input::{fill, mutable, output, present, reference, slice};
use super::light::{UmbrageLight, UmbrageLightId};
use super::scene::{UmbrageFrameInput, UmbrageScene, UmbrageView, Views};
use super::vulkan::*;
use crate::{Counters, Engine, FrameId, LightId};
use std::ffi::{c_char, c_void};

/// The lights and the views of one scene. One thread at a time may use an engine; any thread may be that one.
pub struct UmbrageEngine(Guarded<Engine>);

// what the sentence above promises
const _: fn() = || {
    fn any_thread<T: Send>() {}
    any_thread::<Engine>();
};

/// Bytes of the name of a purpose, its ending zero included.
pub const UMBRAGE_PURPOSE_BYTES: usize = 32;

/// Device memory for one purpose.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct UmbrageMemory {
    /// What it is for, ends with a zero.
    pub purpose: [c_char; UMBRAGE_PURPOSE_BYTES],
    /// How much it is.
    pub bytes: u64,
}

/// # Safety
/// Null, or an engine that was made and not destroyed, which no other thread uses.
unsafe fn change(
    engine: *mut UmbrageEngine,
    run: impl FnOnce(&mut Engine) -> Result<(), Failure>,
) -> Result<(), Failure> {
    // SAFETY: the caller vouches for the pointer
    unsafe { mutable(engine, "the engine")? }.0.change(run)
}

/// # Safety
/// As [`change`].
unsafe fn read<'a>(engine: *const UmbrageEngine) -> Result<&'a Engine, Failure> {
    // SAFETY: the caller vouches for the pointer
    unsafe { reference(engine, "the engine")? }.0.read()
}

fn known_view(engine: &Engine, view: u32) -> Result<usize, Failure> {
    let views = engine.views.len();
    if (view as usize) < views {
        return Ok(view as usize);
    }
    Err(Failure::limit("view", view, format!("0 to {}", views - 1)))
}

/// Makes an engine and everything it needs; nothing is allocated on the device afterwards. views: what each view of a
/// frame sees, 1 to 16; they share pages. Structs and arrays are not kept, Vulkan handles are.
///
/// # Safety
/// All handles must be valid, made with what umbrage_enable_features switches on, and outlive the engine.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_engine_create(
    device: *const UmbrageDevice,
    config: *const UmbrageConfig,
    scene: *const UmbrageScene,
    views: *const UmbrageView,
    view_count: usize,
    engine: *mut *mut UmbrageEngine,
) -> UmbrageResult {
    guard(|| {
        // SAFETY: the caller vouches for pointers and handles
        let made = unsafe {
            let to = output(engine, "engine")?;
            let (config, scene) = (UmbrageConfig::read(config)?, UmbrageScene::read(scene)?);
            let views = Views::read(views, view_count)?;
            let device = UmbrageDevice::read(device)?;
            (to, Engine::new(&device, &config, &scene, &views.receivers()?)?)
        };
        made.0.write(Box::into_raw(Box::new(UmbrageEngine(Guarded::new(made.1)))));
        Ok(())
    })
}

/// Destroys an engine; null is allowed.
///
/// # Safety
/// engine: made and not destroyed, or null; no recorded frame may still be running or waiting to run.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_engine_destroy(engine: *mut UmbrageEngine) {
    guard(|| {
        if !engine.is_null() {
            // SAFETY: made by `umbrage_engine_create`, and the caller gives it up
            drop(unsafe { Box::from_raw(engine) });
        }
        Ok(())
    });
}

/// Adds a light, between frames. UMBRAGE_ERROR_LIMIT for a light out of range, and beyond the config's lights.
///
/// # Safety
/// engine: made and not destroyed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_add_light(
    engine: *mut UmbrageEngine,
    light: *const UmbrageLight,
    id: *mut UmbrageLightId,
) -> UmbrageResult {
    guard(|| {
        // SAFETY: the caller vouches for the pointers
        let (light, id) = unsafe { (reference(light, "light")?.light()?, output(id, "id")?) };
        // SAFETY: as above
        unsafe {
            change(engine, |engine| {
                id.write(engine.add_light(&light)?.to_bits());
                Ok(())
            })
        }
    })
}

/// Changes a light, between frames. Pages of a directional light outlive small turns (drift_texels); those of others
/// are drawn anew after any change. UMBRAGE_ERROR_LIMIT also for the id of a light that was removed.
///
/// # Safety
/// engine: made and not destroyed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_set_light(
    engine: *mut UmbrageEngine,
    id: UmbrageLightId,
    light: *const UmbrageLight,
) -> UmbrageResult {
    guard(|| {
        // SAFETY: the caller vouches for the pointers
        unsafe {
            let light = reference(light, "light")?.light()?;
            change(engine, |engine| Ok(engine.set_light(LightId::from_bits(id), &light)?))
        }
    })
}

/// Removes a light, between frames; its slot may be given to another.
///
/// # Safety
/// engine: made and not destroyed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_remove_light(engine: *mut UmbrageEngine, id: UmbrageLightId) -> UmbrageResult {
    // SAFETY: the caller vouches for the pointer
    guard(|| unsafe { change(engine, |engine| Ok(engine.remove_light(LightId::from_bits(id))?)) })
}

/// Forgets all pages and casters: the next frame is a first one. For hosts that recorded a frame and never submitted
/// it, or changed their buffers without telling.
///
/// # Safety
/// engine: made and not destroyed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_forget(engine: *mut UmbrageEngine) -> UmbrageResult {
    // SAFETY: the caller vouches for the pointer
    guard(|| unsafe {
        change(engine, |engine| {
            engine.forget();
            Ok(())
        })
    })
}

/// Records one frame; inputs: one for each view. The commands take the receivers' images from their last use and the
/// masks to theirs. frame: where its number goes, or null. After an error nothing was recorded. The engine reads the
/// scene's buffers in compute and vertex shaders and as vertices and indices, and writes indices and host_draws in compute
/// shaders. lavapipe (22.3, 25.0) holds indirect draws recorded after these commands in the same command buffer to the
/// engine's count of draws.
///
/// # Safety
/// commands: recording outside of rendering, on a queue with graphics and compute. Every recorded frame of an engine
/// must run, once, in the order of recording and on one queue (else call umbrage_forget). Any number of frames may be
/// in flight. What the host changes in its buffers is ordered before the commands and after those of the frame before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_record(
    engine: *mut UmbrageEngine,
    commands: VkCommandBuffer,
    inputs: *const UmbrageFrameInput,
    input_count: usize,
    frame: *mut u64,
) -> UmbrageResult {
    // SAFETY: the caller vouches for pointers and commands
    guard(|| unsafe { record(engine, commands, (inputs, input_count), (None, std::ptr::null_mut()), frame) })
}

/// Records draws of the host's; user: what was given beside it.
pub type UmbrageDraw = Option<unsafe extern "C" fn(commands: VkCommandBuffer, user: *mut c_void)>;

/// As umbrage_record, for scenes with casters that the host draws (host_draws): draw is called once, before this returns,
/// where their draws belong. It binds pipelines of the host's own with umbrage_casters in their layout and
/// glsl/host/umbrage_caster.glsl in their vertex or tessellation evaluation shader, and records vkCmdDrawIndexedIndirect
/// from host_draws, of one instance or of several that follow each other.
///
/// The commands lie inside of dynamic rendering into a D32_SFLOAT depth attachment of many layers, without colour, of one
/// sample; viewport and scissor are set, for pipelines that have them as dynamic state. Depth is tested and written by
/// GREATER_OR_EQUAL, without bias; both sides cast. A fragment shader may discard. A caster whose shape changes needs another
/// revision or UMBRAGE_CAST_ALWAYS, as pages are kept: let wind or level of detail not depend on the camera.
///
/// # Safety
/// As umbrage_record. draw calls no function of this engine, does not unwind, and leaves the command buffer inside of the same
/// rendering; what it binds stays valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_record_with(
    engine: *mut UmbrageEngine,
    commands: VkCommandBuffer,
    inputs: *const UmbrageFrameInput,
    input_count: usize,
    draw: UmbrageDraw,
    user: *mut c_void,
    frame: *mut u64,
) -> UmbrageResult {
    guard(|| {
        if draw.is_none() {
            return Err(Failure::argument("draw is a null pointer"));
        }
        // SAFETY: the caller vouches for pointers and commands
        unsafe { record(engine, commands, (inputs, input_count), (draw, user), frame) }
    })
}

/// # Safety
/// As [`umbrage_record_with`].
unsafe fn record(
    engine: *mut UmbrageEngine,
    commands: VkCommandBuffer,
    (inputs, input_count): (*const UmbrageFrameInput, usize),
    (draw, user): (UmbrageDraw, *mut c_void),
    frame: *mut u64,
) -> Result<(), Failure> {
    present(commands, "commands")?;
    // SAFETY: the caller vouches for the pointers
    let (inputs, frame) = unsafe {
        let frame = if frame.is_null() { None } else { Some(output(frame, "frame")?) };
        (slice(inputs, input_count, "inputs")?, frame)
    };
    let inputs = inputs.iter().map(UmbrageFrameInput::read).collect::<Result<Vec<_>, _>>()?;
    // SAFETY: the caller vouches for the pointer and for the commands
    unsafe {
        change(engine, |engine| {
            let recorded = match draw {
                None => engine.record(commands, &inputs)?,
                Some(draw) => engine.record_with(commands, &inputs, &mut |commands| draw(commands, user))?,
            };
            frame.map(|frame| frame.write(recorded.number()));
            Ok(())
        })
    }
}

/// Makes the views anew, as many as there were, for other sizes or other images; pages and lights stay. After an error
/// the engine is as it was.
///
/// # Safety
/// As umbrage_engine_create; no recorded frame may still be running or waiting to run.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_resize(
    engine: *mut UmbrageEngine,
    views: *const UmbrageView,
    view_count: usize,
) -> UmbrageResult {
    guard(|| {
        // SAFETY: the caller vouches for pointers and handles
        unsafe {
            let views = Views::read(views, view_count)?;
            change(engine, |engine| Ok(engine.resize(&views.receivers()?)?))
        }
    })
}

/// Tells how long the GPU took for a finished frame, in milliseconds, from which the engine steers its work towards
/// target_ms; without a target, and for a frame whose counters are not kept, nothing happens. tiles_ms: the part of it
/// spent in culling and tiles, 0 where that is not known. Call it once a frame, in order.
///
/// # Safety
/// engine: made and not destroyed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_steer(
    engine: *mut UmbrageEngine,
    frame: u64,
    gpu_ms: f64,
    tiles_ms: f64,
) -> UmbrageResult {
    // SAFETY: the caller vouches for the pointer
    guard(|| unsafe {
        change(engine, |engine| {
            engine.steer(FrameId::from_number(frame), gpu_ms, tiles_ms);
            Ok(())
        })
    })
}

/// Counters of a frame that the caller has waited for. UMBRAGE_ERROR_LIMIT for a frame that was not recorded, or so
/// long ago that frames_in_flight later ones were. struct_size: sizeof(UmbrageCounters).
///
/// # Safety
/// engine: made and not destroyed. counters: room for struct_size bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_counters(
    engine: *const UmbrageEngine,
    frame: u64,
    counters: *mut Counters,
    struct_size: usize,
) -> UmbrageResult {
    guard(|| {
        // SAFETY: the caller vouches for the pointer
        let engine = unsafe { read(engine)? };
        let kept = engine.counters(FrameId::from_number(frame));
        let kept = kept.ok_or_else(|| Failure::limit("frame", frame, "one of the last frames_in_flight"))?;
        // SAFETY: as above
        unsafe { fill(counters, struct_size, &kept, size_of::<Counters>(), "the counters") }
    })
}

/// Device memory by purpose. memory: null to ask for the number of purposes, else room for *count of them. *count
/// becomes the number that there are; UMBRAGE_ERROR_LIMIT where there is less room, which then is filled.
///
/// # Safety
/// engine: made and not destroyed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_memory(
    engine: *const UmbrageEngine,
    memory: *mut UmbrageMemory,
    count: *mut u32,
) -> UmbrageResult {
    guard(|| {
        // SAFETY: the caller vouches for the pointers
        let (engine, count) = unsafe { (read(engine)?, mutable(count, "count")?) };
        let purposes = engine.memory();
        let room = std::mem::replace(count, purposes.len() as u32);
        if memory.is_null() {
            return Ok(());
        }
        for (i, (name, bytes)) in purposes.iter().enumerate().take(room as usize) {
            let mut purpose = [0; UMBRAGE_PURPOSE_BYTES];
            for (to, from) in purpose[..UMBRAGE_PURPOSE_BYTES - 1].iter_mut().zip(name.bytes()) {
                *to = from as c_char;
            }
            // SAFETY: there is room for so many
            unsafe { output(memory.add(i), "memory")?.write(UmbrageMemory { purpose, bytes: *bytes }) };
        }
        if (room as usize) < purposes.len() {
            return Err(Failure::limit("count", room, format!("at least {}", purposes.len())));
        }
        Ok(())
    })
}

/// What shaders of the host bind to look shadows up themselves in a view, after the commands of its frame and before
/// those of the next: glsl/host/umbrage.glsl. layout: for pipeline layouts. set: bound at the number that the shader
/// calls UMBRAGE_SET. They change with umbrage_resize.
///
/// # Safety
/// engine: made and not destroyed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_lookup(
    engine: *const UmbrageEngine,
    view: u32,
    layout: *mut VkDescriptorSetLayout,
    set: *mut VkDescriptorSet,
) -> UmbrageResult {
    guard(|| {
        // SAFETY: the caller vouches for the pointers
        let (engine, layout, set) = unsafe { (read(engine)?, output(layout, "layout")?, output(set, "set")?) };
        let lookup = engine.lookup(known_view(engine, view)?);
        layout.write(lookup.layout);
        set.write(lookup.set);
        Ok(())
    })
}

/// What pipelines of the host bind to draw casters in umbrage_record_with: glsl/host/umbrage_caster.glsl. set: bound at
/// the number that the shader calls UMBRAGE_CASTER_SET. UMBRAGE_ERROR_LIMIT where the scene has no host_draws.
///
/// # Safety
/// engine: made and not destroyed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_casters(
    engine: *const UmbrageEngine,
    layout: *mut VkDescriptorSetLayout,
    set: *mut VkDescriptorSet,
) -> UmbrageResult {
    guard(|| {
        // SAFETY: the caller vouches for the pointers
        let (engine, layout, set) = unsafe { (read(engine)?, output(layout, "layout")?, output(set, "set")?) };
        let casters = engine.casters().ok_or_else(|| Failure::limit("host_draws", "none", "a buffer of draws"))?;
        layout.write(casters.layout);
        set.write(casters.set);
        Ok(())
    })
}

/// The mask of a view, of its size, and a view of all its layers (VK_IMAGE_VIEW_TYPE_2D_ARRAY): R32_UINT images of sampled,
/// storage and transfer source usage with mask_bits for each light, in the order of slots from the lowest bits of the
/// first layer: slot i has the bits from i * mask_bits % 32 on in layer i * mask_bits / 32. 1 lit, 0 shadowed or not reached by the light, 1 where there is no surface,
/// shares with a filter or several samples a pixel. With 32 bits the words are floats, and layer i is the light of slot
/// i. They change with umbrage_resize.
///
/// # Safety
/// engine: made and not destroyed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_mask(
    engine: *const UmbrageEngine,
    view: u32,
    image: *mut VkImage,
    image_view: *mut VkImageView,
) -> UmbrageResult {
    guard(|| {
        // SAFETY: the caller vouches for the pointers
        let (engine, image, image_view) =
            unsafe { (read(engine)?, output(image, "image")?, output(image_view, "image_view")?) };
        let mask = engine.mask(known_view(engine, view)?);
        image.write(mask.0);
        image_view.write(mask.1);
        Ok(())
    })
}
