//! Adaptive shadow maps for Vulkan.

mod camera;
mod config;
pub mod engine;
mod error;
pub mod host;
mod light;

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
pub use config::{Config, Cull, LevelRule, RequestRoute};
pub use engine::Engine;
pub use error::Error;
pub use light::Light;
