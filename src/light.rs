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
    /// Light from a point into a cone.
    Spot {
        /// World space.
        position: DVec3,
        /// Axis of the cone, in the direction of travel. World space, any length but zero.
        direction: DVec3,
        /// Angle from the axis at which the light begins to fade, in degrees; 0 to `outer_angle_deg`. Shadows do not depend
        /// on it.
        inner_angle_deg: f64,
        /// Angle from the axis at which the light ends, in degrees; above 0, at most 90.
        outer_angle_deg: f64,
        /// Distance at which the light ends, world units, above 0.
        range: f64,
    },
    /// Light from a point into all directions.
    Point {
        /// World space.
        position: DVec3,
        /// Distance at which the light ends, world units, above 0.
        range: f64,
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
            Light::Spot { .. } | Light::Point { .. } => false,
            Light::Area { .. } => true,
        }
    }

    /// Whether light would reach a point in world space if nothing stood between: within range and cone.
    pub fn reaches(&self, point: DVec3) -> bool {
        match self {
            Light::Directional { .. } | Light::Area { .. } => true,
            Light::Point { position, range } => (point - position).length() <= *range,
            Light::Spot { position, direction, outer_angle_deg, range, .. } => {
                let q = point - position;
                let along = q.dot(direction.normalize_or_zero());
                q.length() <= *range && along >= q.length() * outer_angle_deg.to_radians().cos()
            }
        }
    }
}
