//! Adaptive shadow maps for Vulkan.

mod camera;
mod error;
mod light;

pub mod gpu;

#[cfg(feature = "lab")]
pub mod methods;
#[cfg(feature = "lab")]
pub mod scene;
#[cfg(feature = "lab")]
pub mod truth;

pub use camera::Camera;
pub use error::Error;
pub use light::Light;
