//! Umbrage: adaptive shadow maps for Vulkan.
//!
//! Every visible sample gets the shadow-map resolution it needs, and no more: resolution-matched shadow maps (Lefohn,
//! Sengupta, Owens 2007) from request to lookup on the GPU, by commands that do not depend on what the GPU finds.
//!
//! # The order in which a host works
//!
//! 1. **Requirements.** [`requirements`] says what to enable on a Vulkan 1.3 device, [`missing_features`] what
//!    a device lacks.
//! 2. **Casters and receivers.** Describe your buffers with [`SceneBuffers`], your depth and normals with
//!    [`Receivers`].
//! 3. **Create.** [`Engine::new`] takes a [`Config`]; it allocates everything, nothing is allocated afterwards.
//!    [`Engine::add_light`], [`Engine::set_light`] and [`Engine::remove_light`] work between frames; a light keeps its id.
//! 4. **Record.** [`Engine::record`] writes one frame into your command buffer, with one input for each view: no submit, no
//!    wait, no read-back.
//! 5. **Sample.** The mask of a view is [`Engine::mask`]; `glsl/host/umbrage_lookup.glsl` is the lookup itself.
//! 6. **Move.** Between frames change instances, positions and bounds in your buffers, and raise the revision of what
//!    casts differently ([`CastPolicy`]); pages of earlier frames stay where nothing changed.
//! 7. **Tune.** [`Engine::counters`] tells what was requested, drawn, put off and refused, [`Engine::memory`] what it
//!    costs; [`Engine::steer`] holds a frame to [`Config::target_ms`].
//!
//! # Features
//!
//! Without features the crate is the engine alone. `capi` adds the C interface (`include/umbrage.h`), `lab` adds glTF scenes, the other methods, the ray-traced reference
//! and pictures; `cli` adds the program `umbrage`.
//!
//! # Spaces and units
//!
//! World space is right-handed; positions on the GPU are relative to the scene's origin or to the eye. Coordinates from
//! the origin come in two single-precision parts (a matrix and `low`, the rest of its translation), so the origin may lie
//! kilometres from the camera; what is farther from the world's own zero gets an origin nearby
//! ([`FrameInput::origin`]). Light space has
//! its x and y axes across the light and z along its travel. Level 0 is the finest; a page of level l covers twice the
//! length of one of level l - 1. Image row 0 is the top, pixel centres lie at +0.5, depth is reversed.

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

pub use camera::Camera;
pub use casters::{
    ALPHA_TESTED, Attributes, CLUSTER_TRIANGLES, CastPolicy, Cluster, Instance, Material, MeshBounds, Meshes,
    NO_TEXTURE,
};
pub use config::{Config, Cull, Filter, LevelRule, Pressure, RequestRoute, sample_places};
pub use engine::{DepthPrepass, Engine, FrameId, LightId, MeshDraw};
pub use error::Error;
pub use gpu::structs::Counters;
pub use gpu::{HostDevice, RayQueryRequirements, Requirements, missing_features, requirements};
pub use host::{FrameInput, HostImage, ImageUse, ReceiverImages, Receivers, SceneBuffers, encode_normal};
pub use light::Light;
