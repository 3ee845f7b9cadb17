//! The viewer: a perspective camera in world space.

use glam::{DMat3, DMat4, DVec3, DVec4};

/// A perspective camera. Right-handed world, the image's row 0 is the top, pixel centres lie at +0.5.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Position of the eye, world space.
    pub eye: DVec3,
    /// A point the camera looks at, world space; must differ from `eye`.
    pub target: DVec3,
    /// Up direction, world space; must not be parallel to the view direction. Any length but zero.
    pub up: DVec3,
    /// Full vertical field of view in degrees, in (0, 180).
    pub fov_y_deg: f64,
    /// Distance of the near plane along the view direction, world units, > 0.
    pub near: f64,
    /// Distance of the far plane along the view direction, world units, > `near`.
    pub far: f64,
}

impl Camera {
    /// Rows: right, up, backward (the direction opposite to the view), all unit vectors in world space.
    pub fn view_from_world(&self) -> DMat3 {
        let back = (self.eye - self.target).normalize();
        let right = self.up.cross(back).normalize();
        let up = back.cross(right);
        DMat3::from_cols(right, up, back).transpose()
    }

    /// Vulkan clip space (y down) from view space, reversed depth (near 1, far 0). `aspect`: width over height.
    pub fn clip_from_view(&self, aspect: f64) -> DMat4 {
        let f = 1.0 / (0.5 * self.fov_y_deg.to_radians()).tan();
        let (n, r) = (self.near, self.far);
        DMat4::from_cols(
            DVec4::new(f / aspect, 0.0, 0.0, 0.0),
            DVec4::new(0.0, -f, 0.0, 0.0),
            // z_clip = (n z_view + n r) / (r - n) with z_view negative in front of the eye
            DVec4::new(0.0, 0.0, n / (r - n), -1.0),
            DVec4::new(0.0, 0.0, n * r / (r - n), 0.0),
        )
    }
}
