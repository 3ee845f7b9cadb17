//! The C interface, `include/umbrage.h`: the Rust API with Vulkan's own C types and plain structs.
//!
//! Every function returns a result code, or hands out nothing that could fail. Panics do not cross the border. The
//! header is made from the files of this folder; `tests/capi.rs` compares.

mod config;
mod device;
mod engine;
mod guard;
mod input;
mod light;
mod meshes;
mod prepass;
mod scene;
mod vulkan;

pub use config::*;
pub use device::*;
pub use engine::*;
pub use guard::*;
pub use light::*;
pub use meshes::*;
pub use prepass::*;
pub use scene::*;
