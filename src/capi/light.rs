//! Lights as plain data.

use super::config::unknown;
use super::guard::Failure;
use super::input::zero;
use crate::Light;
use glam::DVec3;

/// What kind of light: one of UMBRAGE_LIGHT_*.
pub type UmbrageLightKind = u32;
/// Parallel light, such as the sun.
pub const UMBRAGE_LIGHT_DIRECTIONAL: UmbrageLightKind = 0;
/// Light from a point into a cone.
pub const UMBRAGE_LIGHT_SPOT: UmbrageLightKind = 1;
/// Light from a point into all directions.
pub const UMBRAGE_LIGHT_POINT: UmbrageLightKind = 2;

/// A light of an engine, which stays the same until the light is removed; 0 is none. Its low 32 bits are its slot.
pub type UmbrageLightId = u64;

/// A light source. Fields that its kind does not have mean nothing.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UmbrageLight {
    /// What kind of light.
    pub kind: UmbrageLightKind,
    /// Zero.
    pub reserved: u32,
    /// Spot and point: world space.
    pub position: [f64; 3],
    /// Directional and spot: direction in which the light travels, world space, any length but zero.
    pub direction: [f64; 3],
    /// Directional: apparent diameter in degrees; the engine takes 0 only.
    pub angular_diameter_deg: f64,
    /// Spot: angle from the axis at which the light begins to fade, in degrees; 0 to outer_angle_deg. Shadows do not
    /// depend on it.
    pub inner_angle_deg: f64,
    /// Spot: angle from the axis at which the light ends, in degrees; above 0, at most 90.
    pub outer_angle_deg: f64,
    /// Spot and point: distance at which the light ends, world units, above 0.
    pub range: f64,
}

impl UmbrageLight {
    pub(super) fn light(&self) -> Result<Light, Failure> {
        zero(self.reserved)?;
        let (position, direction) = (DVec3::from(self.position), DVec3::from(self.direction));
        match self.kind {
            UMBRAGE_LIGHT_DIRECTIONAL => {
                Ok(Light::Directional { direction, angular_diameter_deg: self.angular_diameter_deg })
            }
            UMBRAGE_LIGHT_SPOT => Ok(Light::Spot {
                position,
                direction,
                inner_angle_deg: self.inner_angle_deg,
                outer_angle_deg: self.outer_angle_deg,
                range: self.range,
            }),
            UMBRAGE_LIGHT_POINT => Ok(Light::Point { position, range: self.range }),
            other => Err(unknown("kind of light", other, "UMBRAGE_LIGHT")),
        }
    }
}

/// Slot of a light: its place in the mask and what the lookup in a shader takes.
#[unsafe(no_mangle)]
pub extern "C" fn umbrage_light_slot(light: UmbrageLightId) -> u32 {
    light as u32
}
