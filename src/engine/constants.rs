//! The constants of a frame: camera rays, light axes and the page grid, computed in double precision.

use crate::config::LevelRule;
use crate::gpu::structs::Frame;
use crate::host::{FrameInput, SceneBuffers};
use crate::{Config, Error};
use glam::{DVec2, DVec3};

/// Level whose pages cover all casters: four of them at most.
pub const ROOT_LEVEL: i32 = 13;

/// Level-0 page on the grid through the origin where keys start: two root pages to each side.
const ANCHOR: i32 = -(1 << ROOT_LEVEL);

/// The page grid of a directional light. All but the axes depends on the scene alone, so that pages outlive small turns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Grid {
    /// Light axes; `z` is the direction of travel.
    pub(crate) axes: [DVec3; 3],
    /// Side of a level-0 page: a power of two, so that page corners are exact in single precision.
    pub(crate) page: f64,
    /// Distance of the farthest caster from the origin: depths reach from minus to plus this.
    pub(crate) reach: f64,
}

/// Unit axes of light space: x and y across the light, z along its travel. They turn smoothly with the light, but where it
/// shines straight up (Duff et al. 2017, with the singular point there).
pub(crate) fn light_axes(direction: DVec3) -> Result<[DVec3; 3], Error> {
    let z = direction.try_normalize().ok_or_else(|| Error::Limit {
        field: "light direction",
        given: format!("{direction}"),
        limit: "any finite vector but zero".into(),
    })?;
    let down = 1.0 - z.y;
    let x = if down > 1e-9 { DVec3::new(1.0 - z.x * z.x / down, z.x, -z.x * z.z / down) } else { DVec3::X };
    let x = (x - z * x.dot(z)).normalize();
    Ok([x, z.cross(x), z])
}

impl Grid {
    pub(crate) fn new(direction: DVec3, scene: &SceneBuffers) -> Result<Self, Error> {
        let axes = light_axes(direction)?;
        let farthest = |i: usize| scene.bounds_min[i].abs().max(scene.bounds_max[i].abs());
        let reach = DVec3::new(farthest(0), farthest(1), farthest(2)).length().max(1e-30) * (1.0 + 1e-5);
        let root = reach.log2().ceil().exp2();
        Ok(Self { axes, page: root / f64::from(1 << ROOT_LEVEL), reach })
    }

    #[cfg(feature = "lab")]
    /// Length of the whole grid: two root pages.
    pub(crate) fn extent(&self) -> f64 {
        self.page * f64::from(2 << ROOT_LEVEL)
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

/// What a frame's constants take from the frames before.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct History {
    /// [`crate::gpu::structs::frame_flags`].
    pub(crate) flags: u32,
    /// Number of the frame, from 1.
    pub(crate) frame: u32,
    /// Level bias beyond the configured one.
    pub(crate) bias: f32,
    /// What drawing a page costs beside its pairs, in pairs.
    pub(crate) page_cost: u32,
}

/// All constants of a frame.
pub(crate) fn constants(
    config: &Config,
    scene: &SceneBuffers,
    input: &FrameInput,
    history: &History,
) -> Result<Frame, Error> {
    let grid = Grid::new(input.light_direction, scene)?;
    let eye = input.camera.eye - input.origin;
    let units = DVec2::new(eye.dot(grid.axes[0]), eye.dot(grid.axes[1])) / grid.page;
    let whole = units.floor();
    let inside = units - whole;
    let page = |v: f64| (v - f64::from(ANCHOR)).clamp(-1e9, 1e9) as i32;
    let word = |v: DVec3, w: f64| [v.x as f32, v.y as f32, v.z as f32, w as f32];
    let interior = f64::from(config.page_texels - 2 * config.gutter);
    let range = 2.0 * grid.reach;
    let bias = f64::from(config.level_bias + history.bias);
    // rounding of a light-space depth: a few units in the last place of the largest coordinate
    let rounding = 8.0 * f64::from(f32::EPSILON) * range;
    Ok(Frame {
        light_x: word(grid.axes[0], inside.x),
        light_y: word(grid.axes[1], inside.y),
        light_z: word(grid.axes[2], eye.dot(grid.axes[2]) + grid.reach),
        eye_page: [page(whole.x), page(whole.y), 0, 0],
        anchor_page: [ANCHOR, ANCHOR, 0, 0],
        page: [grid.page as f32, (1.0 / grid.page) as f32, (1.0 / range) as f32, -grid.reach as f32],
        rule: [
            ((interior / grid.page).powi(2) * (2.0 * bias).exp2()) as f32,
            config.bias_texels,
            rounding as f32,
            interior as f32,
        ],
        size: [config.size[0], config.size[1], u32::from(config.level_rule == LevelRule::MinLength), 0],
        cache: [history.flags, history.frame, config.still_frames, history.page_cost],
        drift: [(grid.reach * interior / grid.page) as f32, config.drift_texels, 0.0, 0.0],
        ..camera_constants(config.size, input)
    })
}
