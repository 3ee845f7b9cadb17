//! The ray-traced reference and the error metrics.

/// What the camera sees, one entry a pixel, row 0 at the top.
#[derive(Debug, Clone, Default)]
pub struct GBuffer {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// World position minus `Scene::origin`; zero where nothing was hit.
    pub position: Vec<[f32; 3]>,
    /// Unit geometric normal towards the eye, world space; zero where nothing was hit.
    pub normal: Vec<[f32; 3]>,
    /// Base colour, linear RGBA8, R in the lowest byte.
    pub albedo: Vec<u32>,
    /// Whether there is a surface.
    pub hit: Vec<bool>,
}
