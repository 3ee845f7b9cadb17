//! Umbrage: adaptive shadow maps for Vulkan.
//!
//! Every visible sample gets the shadow-map resolution it needs, and no more: resolution-matched shadow maps (Lefohn,
//! Sengupta, Owens 2007) from request to lookup on the GPU, by commands that do not depend on what the GPU finds.
//!
//! # Into a renderer, in the order of work
//!
//! **1. Requirements**, before there is a device. [`missing_features`] says in words what a physical device lacks,
//! [`requirements`] what to enable on it: Vulkan 1.3 with dynamic rendering and synchronization2, `multiDrawIndirect`,
//! `drawIndirectFirstInstance`, `shaderOutputLayer`. `drawIndirectCount` and ray queries are used where they are enabled.
//!
//! **2. Casters.** [`Meshes::new`] cuts the triangles of meshes into clusters, once, on the CPU. Upload what it made, the
//! vertices, an [`Instance`] for each placement and at least one [`Material`] into buffers of your own, and name these in
//! [`SceneBuffers`] (all its fields are below). Positions are relative to the scene's origin, which lies best in the middle of the
//! casters.
//!
//! What the engine's draws cannot show (foliage in the wind, tessellation, displacement) the host draws with its own pipelines:
//! flag such instances [`HOST_DRAWN`], give each a mesh of bounds ([`Meshes::add_bounds`]) and a draw command
//! ([`SceneBuffers::host_draws`]), include `glsl/host/umbrage_caster.glsl` in the vertex shader, and record frames by
//! [`Engine::record_with`]. The engine finds the pages of each and writes them into its command: one indirect draw a caster.
//!
//! **3. Receivers.** [`ReceiverImages`] names the depth image that your camera pass leaves, in any format, layout and
//! projection, and geometric normals if you have them. A [`Receivers`] is one view; several views (split screen, mirrors,
//! stereo) share pages.
//!
//! **4. Create.** [`Engine::new`] takes your handles ([`HostDevice`]) and a [`Config`], and allocates everything: nothing is
//! allocated later, but for [`Engine::resize`]. The engine has no queue, no fence and no thread of its own, cannot submit or
//! wait, and keeps no global state: several live on one device. [`Engine::add_light`] gives a [`LightId`] that stays.
//! Dropping the engine frees what it made; the host waits for its frames first.
//!
//! **5. Record**, each frame, into your command buffer after the camera pass: [`Engine::record`] with a [`FrameInput`] for each view. It
//! takes 0.01 ms, allocates nothing, and inserts all barriers, those of your images included. Any number of frames may
//! be in flight.
//!
//! **6. Sample** in one of two ways. The *mask* ([`Engine::mask`]) holds the visibility of every pixel towards every light,
//! with exact edges if wanted: read it at your pixel. Or *look up* in your own shader, for forward passes, volumes and
//! reflections: include `glsl/host/umbrage.glsl`, bind [`Engine::lookup`], call `umbrage_shadow`.
//!
//! **7. Move.** Between frames change instances, positions and bounds in your buffers, and raise the revision of what
//! casts differently ([`CastPolicy`]); pages of earlier frames stay where nothing changed. [`Engine::set_light`] moves lights.
//!
//! At first the atlas is empty, and [`Config::pages_per_frame`] bounds what a frame draws: coarser pages serve for up to ten
//! frames. Where that must not be seen (a cut behind a loading screen, tests) record a few frames first, or raise it.
//!
//! **8. Tune.** [`Engine::counters`] tells what a finished frame asked for, drew, put off and refused, [`Engine::memory`] what
//! it holds; [`Engine::steer`] keeps frames at [`Config::target_ms`]. Every field of [`Config`] says what it costs;
//! `docs/settings.md` has measured curves of them.
//!
//! **9. Debug.** Every object and pass is named where [`HostDevice::debug_utils`] is set. What looks wrong: shadows that
//! stay behind, an instance changed without its revision; nothing but shadow, a depth image whose far end is taken for a surface
//! (check which end `clip_from_view` makes near); shadows that swim with the camera or lie upside down, a `view_from_world` of columns
//! or a `clip_from_view` with y up ([`FrameInput`]); a caster without a shadow, one outside of
//! the bounds, or a mesh of bounds ([`Meshes::add_bounds`]) whose instance is not [`HOST_DRAWN`]; acne with normals from depth, give
//! geometric normals or raise [`Config::bias_texels`]; contact shadows that end early, depth of few bits
//! ([`ReceiverImages::depth`]); coarse shadows, [`Counters::refused`] and [`Counters::shift`], so
//! more [`Config::atlas_bytes`] or [`Config::page_table_bytes`].
//!
//! ```no_run
//! # use umbrage::*;
//! # use ash::vk::{Buffer, BufferUsageFlags as U};
//! # use bytemuck::cast_slice;
//! # fn host(device: HostDevice, positions: Vec<[f32; 3]>, box_indices: Vec<u32>, images: ReceiverImages, camera: Camera,
//! # cmd: ash::vk::CommandBuffer, upload: impl Fn(&[u8], U) -> Buffer) -> Result<(), Error> {
//! // one mesh, placed twice; `upload` stands for your own way to make a buffer, always with STORAGE_BUFFER usage
//! let meshes = Meshes::new(&positions, &[&box_indices])?;
//! let place = |x: f64| Instance::new(&glam::DAffine3::from_translation(glam::DVec3::new(x, 0.0, 0.0)), 0, 0);
//! let instances = [place(-2.0), place(2.0)];
//! let index_capacity = 1 << 20;
//! let mut indices = meshes.indices.clone();
//! indices.resize(indices.len() + index_capacity as usize, 0);
//! let buffers = SceneBuffers {
//!     positions: upload(cast_slice(&positions), U::VERTEX_BUFFER),
//!     position_layout: PositionLayout::PACKED,
//!     attributes: None, // nothing is alpha tested
//!     indices: upload(cast_slice(&indices), U::INDEX_BUFFER),
//!     index_count: meshes.indices.len() as u32,
//!     clusters: upload(cast_slice(&meshes.clusters), U::empty()),
//!     meshlets: upload(cast_slice(&meshes.meshlets), U::empty()),
//!     instances: upload(cast_slice(&instances), U::empty()),
//!     instance_count: instances.len() as u32,
//!     meshes: upload(cast_slice(&meshes.meshes), U::empty()),
//!     materials: upload(cast_slice(&[Material::WHITE]), U::empty()),
//!     texels: upload(&[0; 4], U::empty()),
//!     shapes: None,     // no ray queries
//!     host_draws: None, // the engine draws all casters
//!     caster_count: meshes.caster_count(instances.iter().map(|i| i.mesh)),
//!     alpha_tested: false,
//!     bounds_min: [-3.0, -1.0, -1.0], // of all casters, wherever they move
//!     bounds_max: [3.0, 1.0, 1.0],
//! };
//! let size = [1920, 1080];
//! let views = [Receivers { size, images: &[images], mask: ImageUse::SAMPLED }];
//! // SAFETY: the handles are valid and outlive the engine
//! let mut engine = unsafe { Engine::new(&device, &Config { index_capacity, ..Config::new(size) }, &buffers, &views)? };
//! let sun = engine.add_light(&Light::directional(glam::DVec3::new(0.3, -1.0, 0.2)))?;
//! // each frame, after the camera pass
//! let input = FrameInput::new(&camera, size, glam::DVec3::ZERO);
//! // SAFETY: `cmd` is recording, and will be submitted
//! let frame = unsafe { engine.record(cmd, &[input])? };
//! // once that frame is finished
//! if let Some(counters) = engine.counters(frame) {
//!     println!("{} pages drawn, light {}", counters.drawn, sun.slot());
//! }
//! # Ok(())
//! # }
//! ```
//!
//! `examples/host.rs` is a whole renderer around it, which can draw its casters itself; `examples/wgpu` is one that draws with
//! wgpu.
//!
//! # Features
//!
//! Without features the crate is the engine alone. `capi` adds the C interface (`include/umbrage.h`), `lab` glTF scenes,
//! the other methods, the ray-traced reference and pictures, `window` a window to look through, `cli` the program
//! `umbrage`.
//!
//! # Spaces and units
//!
//! World space is right-handed; positions on the GPU are relative to the scene's origin or to the eye. Coordinates from
//! the origin come in two single-precision parts (a matrix and `low`, the rest of its translation), so the origin may lie
//! kilometres from the camera; what is farther from the world's own zero gets an origin nearby
//! ([`FrameInput::origin`]). Light space has
//! its x and y axes across the light and z along its travel. Level 0 is the finest; a page of level l covers twice the
//! length of one of level l - 1. Image row 0 is the top, pixel centres lie at +0.5; the depth of maps is reversed (greater is nearer
//! to the light), that of the camera as the host has it.

mod camera;
#[cfg(feature = "capi")]
pub mod capi;
mod casters;
mod config;
mod engine;
mod error;
mod host;
mod light;

#[doc(hidden)]
pub mod gpu;

#[cfg(feature = "lab")]
pub mod lab;
#[cfg(feature = "lab")]
pub mod methods;
#[cfg(feature = "lab")]
pub mod output;
#[cfg(feature = "lab")]
pub mod scene;
#[cfg(feature = "lab")]
pub mod truth;
#[cfg(feature = "lab")]
#[doc(hidden)]
pub mod twin;
#[cfg(feature = "lab")]
pub mod view;
#[cfg(feature = "window")]
pub mod window;

pub use camera::Camera;
pub use casters::{
    ALPHA_TESTED, Attributes, CLUSTER_TRIANGLES, CastPolicy, Cluster, HOST_DRAWN, Instance, Material, MeshBounds,
    Meshes, NO_TEXTURE,
};
pub use config::{Config, Cull, Filter, LevelRule, Pressure, RequestRoute, sample_places};
pub use engine::{DepthPrepass, Engine, FrameId, LightId, MeshDraw, ShaderSet};
pub use error::Error;
pub use gpu::structs::Counters;
pub use gpu::{HostDevice, RayQueryRequirements, Requirements, missing_features, requirements};
pub use host::{
    FrameInput, HostImage, ImageUse, PositionFormat, PositionLayout, ReceiverImages, Receivers, SceneBuffers,
    encode_normal,
};
pub use light::Light;
