//! Light sources.

use glam::DVec3;

/// A light source. Hard-shadow methods accept lights without extent only; see [`Light::has_extent`].
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Light {
    /// Parallel light, such as the sun.
    Directional {
        /// Direction in which the light travels, from the light into the scene. World space, any length but zero.
        direction: DVec3,
        /// Apparent diameter in degrees; 0 gives hard shadows.
        angular_diameter_deg: f64,
    },
    /// A planar polygon that emits to its front side; soft shadows only.
    Area {
        /// Corners in order, world space, at least three, in one plane.
        polygon: Vec<DVec3>,
    },
}

impl Light {
    /// A directional light without extent.
    pub fn directional(direction: DVec3) -> Self {
        Light::Directional { direction, angular_diameter_deg: 0.0 }
    }

    /// Whether shadows of this light have a penumbra.
    pub fn has_extent(&self) -> bool {
        match self {
            Light::Directional { angular_diameter_deg, .. } => *angular_diameter_deg > 0.0,
            Light::Area { .. } => true,
        }
    }
}
