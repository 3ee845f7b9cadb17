//! The stages of the engine as plain serial code: what a stage's results must be, with the same overflow rules and the
//! same bits. Tests run both on the same cases. Stems are those of `src/engine` and `glsl/engine`; `contour`,
//! `kernel`, `key`, `light`, `receiver` and `sampling` mirror `glsl/shared`.

#![forbid(unsafe_code)]

pub mod allocate;
pub mod compact;
pub mod contour;
pub mod gradient;
pub mod kernel;
pub mod key;
pub mod light;
pub mod receiver;
pub mod request;
pub mod sampling;
pub mod sort;

pub use crate::engine::constants::{FACES, ROOT_LEVEL};
/// Levels by which the attempts coarsen all requests.
pub const SHIFTS: [u32; 4] = crate::engine::request::SHIFTS;
/// Entries that a workgroup of the sort handles.
pub const BLOCK: u32 = crate::engine::sort::BLOCK;
