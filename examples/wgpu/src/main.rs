//! A renderer on wgpu's Vulkan backend whose shadows Umbrage makes: wgpu draws colour, depth and normals, Umbrage records into a
//! command encoder of wgpu through its raw handle, wgpu shades with the mask. What a Bevy or wgpu user has to do.
//!
//!     cargo run --release --manifest-path examples/wgpu/Cargo.toml -- wgpu.png
//!
//! Ends with an error where the mask is not that of `rmsm` of the same scene and view, or a validation layer complains.

mod device;
mod picture;

use ash::vk;
use std::error::Error;
use umbrage::lab::{Lab, LabOptions, View};
use umbrage::methods::{self, MethodSpec};
use umbrage::scene::{Scene, builtin};
use umbrage::{Camera, Config, Engine, FrameInput, HostImage, ImageUse, Light, Meshes};
use umbrage::{PositionLayout, ReceiverImages, Receivers, SceneBuffers};

type Result<T> = std::result::Result<T, Box<dyn Error>>;
type Vulkan = wgpu::hal::api::Vulkan;

const SIZE: [u32; 2] = [640, 360];
/// Room behind the indices for those that Umbrage compacts, `Config::index_capacity`.
const INDEX_ROOM: u32 = 1 << 20;

fn main() -> Result<()> {
    let out = std::env::args().nth(1).ok_or("usage: umbrage-wgpu-host PICTURE.png")?;
    device::log_errors();
    // the renderer draws no alpha-tested materials, so nothing is cut away
    let mut scene = builtin();
    scene.materials.iter_mut().for_each(|m| m.alpha_cutoff = 0.0);
    scene.instances.iter_mut().for_each(|i| i.flags &= !umbrage::ALPHA_TESTED);
    scene.meshes.iter_mut().for_each(|m| m.alpha_tested = false);
    let reach = scene.diagonal();
    let eye = scene.origin + reach * glam::DVec3::new(0.25, 0.12, 0.3);
    let (near, far) = (1e-3 * reach, 10.0 * reach);
    let camera = Camera { eye, target: scene.origin, up: glam::DVec3::Y, fov_y_deg: 50.0, near, far };
    let sun = Light::directional(glam::DVec3::new(-0.5, -1.0, 0.3));

    let (pixels, mask) = render(&scene, &camera, &sun)?;
    let rgb: Vec<u8> = pixels.iter().flat_map(|p| p.to_le_bytes().into_iter().take(3)).collect();
    let picture = umbrage::output::Picture { width: SIZE[0], height: SIZE[1], rgb };
    umbrage::output::write_png(std::path::Path::new(&out), &picture)?;

    let view = View { camera, lights: vec![sun], size: SIZE, time_s: 0.0 };
    let lab = Lab::new(&LabOptions { device: None, validation: false }, scene, view)?;
    let mut method = methods::create(&MethodSpec::parse("rmsm")?, &lab)?;
    (0..3).try_for_each(|_| method.frame(&lab).map(drop))?;
    let want = method.visibility(&lab, 0)?;
    let differ = mask.iter().zip(&want).filter(|(a, b)| a != b).count();
    println!("{differ} of {} pixels differ from rmsm", want.len());
    match device::errors() {
        0 if differ <= want.len() / 2000 && mask.contains(&0.0) => Ok(()),
        0 => Err(format!("{differ} pixels differ from rmsm").into()),
        errors => Err(format!("{errors} validation messages").into()),
    }
}

/// Draws three frames and returns the last picture and its mask.
fn render(scene: &Scene, camera: &Camera, sun: &Light) -> Result<(Vec<u32>, Vec<f32>)> {
    let gpu = device::Gpu::new()?;
    // buffers that both use are made on the raw device and lent to wgpu
    use vk::BufferUsageFlags as U;
    let triangles: Vec<&[u32]> =
        scene.meshes.iter().map(|m| &scene.indices[m.first_index as usize..][..m.index_count as usize]).collect();
    let meshes = Meshes::new(&scene.positions, &triangles)?;
    let mut indices = meshes.indices.clone();
    indices.resize(indices.len() + INDEX_ROOM as usize, 0);
    let storage = |bytes: &[u8], usage| gpu.buffer(bytes, U::STORAGE_BUFFER | usage);
    let buffers = SceneBuffers {
        positions: storage(bytemuck::cast_slice(&scene.positions), U::VERTEX_BUFFER)?,
        position_layout: PositionLayout::PACKED,
        attributes: None,
        indices: storage(bytemuck::cast_slice(&indices), U::INDEX_BUFFER)?,
        index_count: meshes.indices.len() as u32,
        clusters: storage(bytemuck::cast_slice(&meshes.clusters), U::empty())?,
        meshlets: storage(bytemuck::cast_slice(&meshes.meshlets), U::empty())?,
        instances: storage(bytemuck::cast_slice(&scene.instances), U::empty())?,
        instance_count: scene.instances.len() as u32,
        meshes: storage(bytemuck::cast_slice(&meshes.meshes), U::empty())?,
        materials: storage(bytemuck::cast_slice(&scene.materials), U::empty())?,
        texels: storage(&[0; 16], U::empty())?,
        shapes: None,
        host_draws: None,
        caster_count: meshes.caster_count(scene.instances.iter().map(|i| i.mesh)),
        alpha_tested: false,
        bounds_min: (scene.bounds_min - scene.origin).to_array(),
        bounds_max: (scene.bounds_max - scene.origin).to_array(),
    };
    let input = FrameInput::new(camera, SIZE, scene.origin);
    let renderer = picture::Renderer::new(&gpu, scene, &buffers, &input)?;

    // wgpu's textures; wgpu leaves them as attachments and expects them so again
    let lent = |texture, view, format, used| -> Result<HostImage> {
        let (image, view) = (gpu.raw_texture(texture)?, gpu.raw_view(view)?);
        Ok(HostImage { image, view, format, samples: vk::SampleCountFlags::TYPE_1, layer: 0, used })
    };
    let attached = ImageUse { layout: vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL, ..ImageUse::DEPTH_ATTACHMENT };
    let depth = lent(&renderer.depth, &renderer.depth_view, vk::Format::D32_SFLOAT, attached)?;
    let normal = lent(&renderer.normal, &renderer.normal_view, vk::Format::R32_UINT, ImageUse::COLOR_ATTACHMENT)?;
    let images = [ReceiverImages { depth, normal: Some(normal) }];
    let views = [Receivers { size: SIZE, images: &images, mask: ImageUse::COPIED }];
    let config = Config { index_capacity: INDEX_ROOM, ..Config::new(SIZE) };
    // SAFETY: the device was opened with what is required, and outlives the engine
    let mut engine = unsafe { Engine::new(&gpu.host, &config, &buffers, &views)? };
    engine.add_light(sun)?;

    for _ in 0..3 {
        // three encoders, one submission: wgpu keeps their order, and Umbrage the barriers between them
        let scene_pass = renderer.draw(&gpu);
        let mut recorded = None;
        let shadow_pass = gpu.raw_encoder(|cmd| {
            // SAFETY: `cmd` is recording outside of rendering and is submitted below
            recorded = Some(unsafe { engine.record(cmd, &[input]) });
            gpu.copy_mask(cmd, engine.mask(0).0, renderer.mask);
        })?;
        let shading_pass = renderer.shade(&gpu);
        gpu.queue.submit([scene_pass, shadow_pass, shading_pass]);
        gpu.wait()?;
        recorded.ok_or("nothing was recorded")??;
    }
    renderer.read(&gpu)
}
