//! The ray-traced reference and the error metrics.

#![forbid(unsafe_code)]

mod alpha;
mod bvh;
mod coverage;
mod crawl;
mod metrics;
mod reference;
mod soft;
mod trace;
mod turned;

pub use alpha::alpha_at;
pub use coverage::{CoverageError, compare_coverage, reference_coverage};
pub use crawl::{Crawl, crawl};
pub use metrics::{Metrics, PixelClass, classify, compare, rmse};
pub use reference::{DECIDED_N_DOT_L, Reference, ray_offsets, reference, trace_visibility};
pub use soft::{SOFT_SAMPLES, reference_soft};
pub use trace::Tracer;

pub(crate) use reference::{snap, to_light};
pub(crate) use turned::Turned;

use glam::{DVec3, Vec3};

/// An input that the reference or a metric cannot use.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{what}")]
pub struct TruthError {
    /// The cause in one clause, with the offending value and what is allowed.
    pub what: String,
}

impl TruthError {
    fn new(what: impl Into<String>) -> Self {
        Self { what: what.into() }
    }
}

/// What the camera sees, one entry a pixel, row 0 at the top.
#[derive(Debug, Clone, Default)]
pub struct GBuffer {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Position of the eye minus [`Scene::origin`](crate::scene::Scene::origin), world axes.
    pub eye: DVec3,
    /// What the view ray of unit depth changes from a pixel to the next, to the right and down; world axes, finite and not 0.
    pub ray_steps: [DVec3; 2],
    /// World position minus that of the eye; zero where nothing was hit.
    pub position: Vec<[f32; 3]>,
    /// Unit geometric normal towards the eye, world space; zero where nothing was hit.
    pub normal: Vec<[f32; 3]>,
    /// Base colour, linear RGBA8, R in the lowest byte.
    pub albedo: Vec<u32>,
    /// Whether there is a surface.
    pub hit: Vec<bool>,
}

impl GBuffer {
    /// Position of a pixel's surface relative to [`Scene::origin`](crate::scene::Scene::origin).
    pub fn point(&self, pixel: usize) -> DVec3 {
        self.eye + Vec3::from_array(self.position[pixel]).as_dvec3()
    }

    /// World size of a pixel at its surface, across the view ray.
    pub fn footprint(&self, pixel: usize) -> f64 {
        self.ray_steps[1].length() * Vec3::from_array(self.position[pixel]).as_dvec3().length()
    }

    /// Number of pixels; an error if a list has another length or there is no pixel.
    fn checked_len(&self) -> Result<usize, TruthError> {
        let want = self.width as usize * self.height as usize;
        if want == 0 {
            return Err(TruthError::new(format!(
                "the G-buffer is {}x{} pixels, at least 1x1 is needed",
                self.width, self.height
            )));
        }
        let [right, down] = self.ray_steps;
        let area = right.cross(down).length();
        if !(area > 0.0 && area.is_finite() && self.eye.is_finite()) {
            return Err(TruthError::new(format!(
                "the G-buffer's eye is {} and the steps of its rays {right} and {down}, finite numbers and steps that span \
                 a pixel are needed",
                self.eye
            )));
        }
        for (name, len) in [("position", self.position.len()), ("normal", self.normal.len()), ("hit", self.hit.len())] {
            if len != want {
                return Err(TruthError::new(format!(
                    "G-buffer {name} has {len} entries, {}x{} pixels need {want}",
                    self.width, self.height
                )));
            }
        }
        Ok(want)
    }
}
