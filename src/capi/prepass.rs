//! The engine's own depth and normals, for hosts that have none.

use super::device::UmbrageDevice;
use super::guard::{UmbrageResult, guard};
use super::input::{output, present, reference, slice};
use super::scene::{UmbrageFrameInput, UmbrageReceiverImages, UmbrageScene};
use super::vulkan::{VkBool32, VkCommandBuffer};
use crate::{DepthPrepass, MeshDraw};

/// Draws depth and normals of a scene, for hosts that have none to give.
pub struct UmbragePrepass(DepthPrepass);

/// One instanced draw: a mesh with all its instances.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct UmbrageMeshDraw {
    /// Number of indices.
    pub index_count: u32,
    /// First index.
    pub first_index: u32,
    /// Number of instances.
    pub instance_count: u32,
    /// First instance.
    pub first_instance: u32,
    /// Whether fragments are cut away by alpha.
    pub alpha_tested: VkBool32,
}

/// Makes images of width x height pixels, 1 to 16384 each, and the pipelines.
///
/// # Safety
/// As umbrage_engine_create.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_prepass_create(
    device: *const UmbrageDevice,
    scene: *const UmbrageScene,
    width: u32,
    height: u32,
    prepass: *mut *mut UmbragePrepass,
) -> UmbrageResult {
    guard(|| {
        // SAFETY: the caller vouches for pointers and handles
        let (to, made) = unsafe {
            let to = output(prepass, "prepass")?;
            let scene = UmbrageScene::read(scene)?;
            (to, DepthPrepass::new(&UmbrageDevice::read(device)?, [width, height], &scene)?)
        };
        to.write(Box::into_raw(Box::new(UmbragePrepass(made))));
        Ok(())
    })
}

/// Destroys a prepass; null is allowed.
///
/// # Safety
/// prepass: made and not destroyed, or null; nothing recorded may still be running or waiting to run.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_prepass_destroy(prepass: *mut UmbragePrepass) {
    guard(|| {
        if !prepass.is_null() {
            // SAFETY: made by `umbrage_prepass_create`, and the caller gives it up
            drop(unsafe { Box::from_raw(prepass) });
        }
        Ok(())
    });
}

/// Its depth and normals, as views take them.
///
/// # Safety
/// prepass: made and not destroyed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_prepass_images(
    prepass: *const UmbragePrepass,
    images: *mut UmbrageReceiverImages,
) -> UmbrageResult {
    guard(|| {
        // SAFETY: the caller vouches for the pointers
        let (UmbragePrepass(prepass), to) = unsafe { (reference(prepass, "prepass")?, output(images, "images")?) };
        to.write(prepass.images().into());
        Ok(())
    })
}

/// Draws; leaves the images readable by compute shaders. The projection must have reversed depth.
///
/// # Safety
/// prepass: made and not destroyed. commands: recording outside of rendering. Frames must run in the order they were
/// recorded. draws: inside of the scene's indices and instances, as many as draw_count says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn umbrage_prepass_record(
    prepass: *const UmbragePrepass,
    commands: VkCommandBuffer,
    input: *const UmbrageFrameInput,
    draws: *const UmbrageMeshDraw,
    draw_count: usize,
) -> UmbrageResult {
    guard(|| {
        present(commands, "commands")?;
        // SAFETY: the caller vouches for the pointers
        let (UmbragePrepass(prepass), input, draws) = unsafe {
            (reference(prepass, "prepass")?, reference(input, "input")?.read()?, slice(draws, draw_count, "draws")?)
        };
        let draw = |d: &UmbrageMeshDraw| MeshDraw {
            index_count: d.index_count,
            first_index: d.first_index,
            instance_count: d.instance_count,
            first_instance: d.first_instance,
            alpha_tested: d.alpha_tested != 0,
        };
        let draws: Vec<_> = draws.iter().map(draw).collect();
        // SAFETY: the caller vouches for the commands and for what the draws name
        unsafe { prepass.record(commands, &input, &draws)? };
        Ok(())
    })
}
