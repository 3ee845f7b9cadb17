//! A renderer that brings up Vulkan by itself and has Umbrage make its shadows: its own pass draws colour, depth and
//! normals, Umbrage records into the same command buffer, its own pass after that reads the mask.
//!
//!     cargo run --release --example host --features lab -- host.png [WIND]
//!
//! With a WIND (0.02 is a light one) the host draws the casters itself, with a shader of its own that bends them.
//! Only the scene and the picture come from the lab; everything else is what a host has to write. Debugging: with
//! `VK_LAYER_KHRONOS_validation` installed, `HOST_VALIDATION=1` turns it on.

use ash::vk;
use glam::Vec3;
use std::error::Error;
use std::sync::atomic::Ordering;
use umbrage::scene::{Mesh, Scene};
use umbrage::{Camera, CastPolicy, Config, Engine, FrameInput, HostImage, ImageUse, Instance, Light, Meshes};
use umbrage::{PositionLayout, ReceiverImages, Receivers, SceneBuffers};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Width and height of the picture.
pub const SIZE: [u32; 2] = [640, 360];
/// Where positions lie in the vertices.
const POSITIONS: PositionLayout = PositionLayout { stride: 20, offset: 8, ..PositionLayout::PACKED };
/// Room behind the indices for those that Umbrage compacts, `Config::index_capacity`.
const INDEX_ROOM: u32 = 1 << 20;

#[cfg_attr(test, allow(dead_code))] // a test runs the renderer alone
fn main() -> Result<()> {
    const USAGE: &str = "usage: host PICTURE.png [WIND]";
    let out = std::env::args().nth(1).ok_or(USAGE)?;
    let wind = std::env::args().nth(2).map(|wind| wind.parse().map_err(|_| USAGE)).transpose()?;
    let winds = [wind.unwrap_or(0.0); 3];
    let bent = Bent { winds: &winds, policy: CastPolicy::Auto, tessellated: false };
    let scene = opaque(umbrage::scene::builtin());
    let vulkan = Vulkan::new(std::env::var_os("HOST_VALIDATION").is_some())?;
    let [pixels, _] = render(&vulkan, &scene, &look(&scene), true, &Config::new(SIZE), wind.and(Some(&bent)))?;
    let lit = pixels.iter().filter(|p| **p >> 24 == 255).count();
    println!("{lit} of {} pixels are lit", pixels.len());
    let rgb: Vec<u8> = pixels.iter().flat_map(|p| p.to_le_bytes().into_iter().take(3)).collect();
    let [width, height] = SIZE;
    if MESSAGES.load(Ordering::Relaxed) > 0 {
        return Err("the validation layer complained".into());
    }
    image::save_buffer(&out, &rgb, width, height, image::ColorType::Rgb8)?;
    Ok(())
}

/// The host draws no alpha-tested materials, so nothing is cut away.
pub fn opaque(mut scene: Scene) -> Scene {
    scene.materials.iter_mut().for_each(|m| m.alpha_cutoff = 0.0);
    scene.instances.iter_mut().for_each(|i| i.flags &= !umbrage::ALPHA_TESTED);
    scene.meshes.iter_mut().for_each(|m| m.alpha_tested = false);
    scene
}

/// Where the camera stands, and the sun.
pub fn look(scene: &Scene) -> (Camera, Light) {
    let reach = scene.diagonal();
    let eye = scene.origin + reach * glam::DVec3::new(0.25, 0.12, 0.3);
    let (near, far) = (1e-3 * reach, 10.0 * reach);
    let camera = Camera { eye, target: scene.origin, up: glam::DVec3::Y, fov_y_deg: 50.0, near, far };
    (camera, Light::directional(glam::DVec3::new(-0.5, -1.0, 0.3)))
}

/// Casters that the host draws itself, bent by the wind.
pub struct Bent<'a> {
    /// In each frame.
    pub winds: &'a [f32],
    /// How they are cached. Where the wind changes, they always change.
    pub policy: CastPolicy,
    /// By another pipeline of the host's.
    pub tessellated: bool,
}

impl Bent<'_> {
    /// Makes an instance one that the host draws: of a mesh with nothing but bounds, whatever the wind.
    fn take(&self, scene: &Scene, instance: &mut Instance, meshes: &mut Meshes) -> Result<[u32; 5]> {
        let Mesh { first_index, index_count, .. } = scene.meshes[instance.mesh as usize];
        let corners = &scene.indices[first_index as usize..][..index_count as usize];
        let positions = || corners.iter().map(|&i| Vec3::from(scene.positions[i as usize]));
        let bent = || self.winds.iter().flat_map(|&wind| positions().map(move |p| p + Vec3::X * wind * p.y * p.y));
        let (low, high) = (bent().fold(Vec3::INFINITY, Vec3::min), bent().fold(Vec3::NEG_INFINITY, Vec3::max));
        let mesh = meshes.add_bounds(low.to_array(), high.to_array())?;
        *instance = Instance { mesh, ..*instance }.with_policy(self.policy).host_drawn();
        // index count, instance count, first index, vertex offset, first instance: Umbrage writes the second and the last
        Ok([index_count, 0, first_index, 0, 0])
    }
}

/// What the host has: a scene in buffers, and the images it draws into.
pub struct Content {
    /// For Umbrage, and for the host's own passes.
    pub buffers: SceneBuffers,
    /// What its camera pass draws.
    pub color: Image,
    /// The same.
    pub normal: Image,
    /// The same.
    pub depth: Image,
}

impl Content {
    /// Uploads a scene: vertices, triangles of each mesh and placed instances; Umbrage cuts the meshes into clusters.
    pub fn new(vulkan: &Vulkan, scene: &Scene, bent: Option<&Bent<'_>>) -> Result<Self> {
        use vk::BufferUsageFlags as U;
        let triangles: Vec<&[u32]> =
            scene.meshes.iter().map(|m| &scene.indices[m.first_index as usize..][..m.index_count as usize]).collect();
        let mut meshes = Meshes::new(&scene.positions, &triangles)?;
        let mut instances = scene.instances.clone();
        let taken = |bent: &Bent<'_>| instances.iter_mut().map(|i| bent.take(scene, i, &mut meshes)).collect();
        let draws: Option<Vec<_>> = bent.map(taken).transpose()?;
        let mut indices = meshes.indices.clone();
        indices.resize(indices.len() + INDEX_ROOM as usize, 0);
        // vertices as this renderer has them: eight bytes of its own before each position
        let vertices: Vec<[f32; 5]> = scene.positions.iter().map(|p| [0.5, 0.5, p[0], p[1], p[2]]).collect();
        let storage = |bytes: &[u8], usage| vulkan.buffer(bytes, U::STORAGE_BUFFER | usage);
        let buffers = SceneBuffers {
            positions: storage(bytemuck::cast_slice(&vertices), U::VERTEX_BUFFER)?,
            position_layout: POSITIONS,
            attributes: None,
            indices: storage(bytemuck::cast_slice(&indices), U::INDEX_BUFFER)?,
            index_count: meshes.indices.len() as u32,
            clusters: storage(bytemuck::cast_slice(&meshes.clusters), U::empty())?,
            meshlets: storage(bytemuck::cast_slice(&meshes.meshlets), U::empty())?,
            instances: storage(bytemuck::cast_slice(&instances), U::empty())?,
            instance_count: scene.instances.len() as u32,
            meshes: storage(bytemuck::cast_slice(&meshes.meshes), U::empty())?,
            materials: storage(bytemuck::cast_slice(&scene.materials), U::empty())?,
            texels: storage(&[0; 16], U::empty())?,
            shapes: None,
            host_draws: draws.map(|draws| storage(bytemuck::cast_slice(&draws), U::INDIRECT_BUFFER)).transpose()?,
            caster_count: meshes.caster_count(instances.iter().map(|i| i.mesh)),
            alpha_tested: false,
            bounds_min: (scene.bounds_min - scene.origin).to_array(),
            bounds_max: (scene.bounds_max - scene.origin).to_array(),
        };
        use vk::ImageUsageFlags as I;
        Ok(Self {
            buffers,
            color: vulkan.image(vk::Format::R8G8B8A8_UNORM, I::COLOR_ATTACHMENT | I::SAMPLED)?,
            normal: vulkan.image(vk::Format::R32_UINT, I::COLOR_ATTACHMENT | I::SAMPLED)?,
            depth: vulkan.image(vk::Format::D32_SFLOAT, I::DEPTH_STENCIL_ATTACHMENT | I::SAMPLED)?,
        })
    }

    /// What Umbrage sees of it, as the host's pass leaves it.
    pub fn images(&self, normals: bool) -> [ReceiverImages; 1] {
        let given = |(image, view), format, used| {
            let samples = vk::SampleCountFlags::TYPE_1;
            HostImage { image, view, format, samples, layer: 0, used }
        };
        let normal = || given(self.normal, vk::Format::R32_UINT, ImageUse::COLOR_ATTACHMENT);
        let depth = given(self.depth, vk::Format::D32_SFLOAT, ImageUse::DEPTH_ATTACHMENT);
        [ReceiverImages { depth, normal: normals.then(normal) }]
    }
}

/// Draws frames of a scene, three if nothing is bent, and returns the last, shaded by the mask and by lookups in the host's own
/// shader: colour, and visibility in the highest byte. `normals`: whether Umbrage sees the host's, or makes its own from
/// depth; `config`: of the engine.
pub fn render(
    vulkan: &Vulkan,
    scene: &Scene,
    (camera, sun): &(Camera, Light),
    normals: bool,
    config: &Config,
    bent: Option<&Bent<'_>>,
) -> Result<[Vec<u32>; 2]> {
    let content = Content::new(vulkan, scene, bent)?;
    let Content { buffers, color, normal, depth } = &content;
    let images = content.images(normals);
    let views = [Receivers { size: SIZE, images: &images, mask: ImageUse::SAMPLED }];

    // the engine, and its only light
    let config = Config { index_capacity: INDEX_ROOM, ..config.clone() };
    // SAFETY: the device has what `requirements` asks for, and everything outlives the engine
    let mut engine = unsafe { Engine::new(&vulkan.host, &config, buffers, &views)? };
    engine.add_light(sun)?;
    let input = FrameInput::new(camera, SIZE, scene.origin);

    // two ways to use it: the mask, or lookups
    let (_, mask) = engine.mask(0);
    let usage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
    let picture = || vulkan.host_visible(4 * u64::from(SIZE[0] * SIZE[1]), usage);
    let (shaded, looked_up) = (picture()?, picture()?);
    let before = vulkan.draw_pipeline(Pass::Camera)?;
    let shade = vulkan.shade_pipeline(color.1, mask, shaded.0)?;
    let forward = vulkan.draw_pipeline(Pass::Forward(engine.lookup(0)))?;
    let drawn = vulkan
        .image(vk::Format::R8G8B8A8_UNORM, vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC)?;
    // casters of the host's own
    let tessellated = bent.is_some_and(|bent| bent.tessellated);
    let pass = engine.casters().map(|set| if tessellated { Pass::Patches(set) } else { Pass::Casters(set) });
    let casters = pass.map(|pass| vulkan.draw_pipeline(pass)).transpose()?;
    for &wind in bent.map_or(&[0.0; 3][..], |bent| bent.winds) {
        let geometry = Geometry { buffers, scene, input: &input, wind };
        let mut recorded = None;
        vulkan.submit(|cmd| {
            vulkan.draw(cmd, &before, [*color, *normal, *depth], &geometry);
            // SAFETY: recording, outside of rendering; every frame is submitted, in order
            recorded = Some(unsafe {
                match &casters {
                    None => engine.record(cmd, &[input]),
                    Some(pipeline) => {
                        engine.record_with(cmd, &[input], &mut |cmd| vulkan.casters(cmd, pipeline, &geometry))
                    }
                }
            });
            vulkan.shade(cmd, &shade);
            vulkan.forward(cmd, &forward, [drawn, *depth], looked_up.0, &geometry);
        })?;
        if let Some(counters) = recorded.transpose()?.and_then(|frame| engine.counters(frame)) {
            println!("{} pages asked for, {} drawn", counters.leaves, counters.drawn);
        }
    }
    let count = (SIZE[0] * SIZE[1]) as usize;
    // SAFETY: mapped for as long as the device lives; the last frame was waited for
    Ok([shaded, looked_up].map(|(_, at)| unsafe { std::slice::from_raw_parts(at.cast::<u32>(), count) }.to_vec()))
}

#[path = "host/vulkan.rs"]
mod vulkan;
use vulkan::Image;
pub use vulkan::{Geometry, MESSAGES, Pass, Vulkan};
