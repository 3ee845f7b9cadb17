//! The constants of a frame: camera rays, light axes and the page grid, computed in double precision.

use crate::config::LevelRule;
use crate::gpu::structs::Frame;
use crate::host::{FrameInput, SceneBuffers};
use crate::{Config, Error};
use glam::{DVec2, DVec3};

/// Level whose pages cover all casters: four of them at most.
pub const ROOT_LEVEL: i32 = 13;

/// The page grid of a directional light, anchored at the scene's origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Grid {
    /// Light axes; `z` is the direction of travel.
    pub(crate) axes: [DVec3; 3],
    /// Side of a level-0 page: a power of two, so that page corners are exact in single precision.
    pub(crate) page: f64,
    /// Level-0 page on the grid through the origin where keys start.
    pub(crate) anchor: [i64; 2],
    /// Depths of the nearest and the farthest caster.
    pub(crate) depth: [f64; 2],
    /// Magnitude of the largest light-space coordinate, for rounding.
    pub(crate) reach: f64,
}

/// Unit axes of light space: x and y across the light, z along its travel.
pub(crate) fn light_axes(direction: DVec3) -> Result<[DVec3; 3], Error> {
    let z = direction.try_normalize().ok_or_else(|| Error::Limit {
        field: "light direction",
        given: format!("{direction}"),
        limit: "any finite vector but zero".into(),
    })?;
    let up = if z.y.abs() < 0.99 { DVec3::Y } else { DVec3::X };
    let x = up.cross(z).normalize();
    Ok([x, z.cross(x), z])
}

impl Grid {
    pub(crate) fn new(direction: DVec3, scene: &SceneBuffers) -> Result<Self, Error> {
        let axes = light_axes(direction)?;
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for corner in 0..8 {
            let pick = |i: usize| if corner >> i & 1 == 0 { scene.bounds_min[i] } else { scene.bounds_max[i] };
            let p = DVec3::new(pick(0), pick(1), pick(2));
            let ls = DVec3::new(p.dot(axes[0]), p.dot(axes[1]), p.dot(axes[2]));
            (low, high) = (low.min(ls), high.max(ls));
        }
        let margin = 1e-5 * (high - low).max_element().max(1e-30);
        (low, high) = (low - margin, high + margin);
        let root = (high - low).truncate().max_element().log2().ceil().exp2();
        let anchor = |v: f64| (v / root).floor() as i64 * (1 << ROOT_LEVEL);
        Ok(Self {
            axes,
            page: root / f64::from(1 << ROOT_LEVEL),
            anchor: [anchor(low.x), anchor(low.y)],
            depth: [low.z, high.z],
            reach: low.abs().max(high.abs()).max_element(),
        })
    }
}

/// Constants that depend on the camera alone; the light's are zero.
pub(crate) fn camera_constants(size: [u32; 2], input: &FrameInput) -> Frame {
    let camera = &input.camera;
    let aspect = f64::from(size[0]) / f64::from(size[1]);
    let view = camera.view_from_world();
    let (right, up, back) = (view.row(0), view.row(1), view.row(2));
    let half = (0.5 * camera.fov_y_deg.to_radians()).tan();
    let dx = right * (2.0 * half * aspect / f64::from(size[0]));
    let dy = up * (-2.0 * half / f64::from(size[1]));
    let corner = -back + up * half - right * (half * aspect);
    let word = |v: DVec3, w: f64| [v.x as f32, v.y as f32, v.z as f32, w as f32];
    Frame {
        clip_from_eye: camera.clip_from_eye_relative(aspect).to_cols_array_2d(),
        ray_corner: word(corner, camera.near),
        ray_dx: word(dx, camera.far),
        ray_dy: word(dy, dy.length()),
        eye: word(camera.eye - input.origin, 0.0),
        size: [size[0], size[1], 0, 0],
        ..bytemuck::Zeroable::zeroed()
    }
}

/// All constants of a frame.
pub(crate) fn constants(config: &Config, scene: &SceneBuffers, input: &FrameInput) -> Result<Frame, Error> {
    let grid = Grid::new(input.light_direction, scene)?;
    let eye = input.camera.eye - input.origin;
    let units = DVec2::new(eye.dot(grid.axes[0]), eye.dot(grid.axes[1])) / grid.page;
    let whole = units.floor();
    let inside = units - whole;
    let page = |v: f64, anchor: i64| (v - anchor as f64).clamp(-1e9, 1e9) as i32;
    let word = |v: DVec3, w: f64| [v.x as f32, v.y as f32, v.z as f32, w as f32];
    let interior = f64::from(config.page_texels - 2 * config.gutter);
    let range = grid.depth[1] - grid.depth[0];
    // rounding of a light-space depth: a few units in the last place of the largest coordinate
    let rounding = 8.0 * f64::from(f32::EPSILON) * grid.reach.max(range);
    Ok(Frame {
        light_x: word(grid.axes[0], inside.x),
        light_y: word(grid.axes[1], inside.y),
        light_z: word(grid.axes[2], eye.dot(grid.axes[2]) - grid.depth[0]),
        eye_page: [page(whole.x, grid.anchor[0]), page(whole.y, grid.anchor[1]), 0, 0],
        anchor_page: [grid.anchor[0] as i32, grid.anchor[1] as i32, 0, 0],
        page: [grid.page as f32, (1.0 / grid.page) as f32, (1.0 / range) as f32, grid.depth[0] as f32],
        rule: [
            ((interior / grid.page).powi(2) * (2.0 * f64::from(config.level_bias)).exp2()) as f32,
            config.bias_texels,
            rounding as f32,
            interior as f32,
        ],
        size: [config.size[0], config.size[1], u32::from(config.level_rule == LevelRule::MinLength), 0],
        ..camera_constants(config.size, input)
    })
}
