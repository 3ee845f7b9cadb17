//! The constants of a frame: camera rays, and what the passes need of each light, computed in double precision.

use crate::config::LevelRule;
use crate::gpu::structs::{Frame, LightRecord, light_kind};
use crate::host::{FrameInput, SceneBuffers};
use crate::{Config, Error, Light};
use bytemuck::Zeroable;
use glam::{DMat2, DMat3, DMat4, DVec2, DVec3};

/// The coarsest level: one page holds all that a face sees.
pub const ROOT_LEVEL: i32 = 23;

/// Faces of a light; directional and most spot lights use the first only.
pub const FACES: u32 = 6;

/// Level-0 pages from the middle of a face to its side.
const HALF: i32 = 1 << (ROOT_LEVEL - 1);

/// Spots that open farther, in degrees from the axis, are seen through the faces of a cube.
pub(crate) const WIDEST_FACE_DEG: f64 = 60.0;

/// Distance of the farthest caster within a light's range over that of its near plane.
const RANGE_OVER_NEAR: f64 = 4096.0;

/// The page grid of a directional light. All but the axes depends on the scene alone, so that pages outlive small turns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Grid {
    /// Light axes; `z` is the direction of travel.
    pub(crate) axes: [DVec3; 3],
    /// Half the side of the face: a power of two, so that page corners are exact in single precision.
    pub(crate) half: f64,
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
        Ok(Self { axes, half: reach.log2().ceil().exp2(), reach })
    }
}

fn word(v: DVec3, w: f64) -> [f32; 4] {
    [v.x as f32, v.y as f32, v.z as f32, w as f32]
}

/// What single precision leaves of a vector.
fn left(v: DVec3) -> DVec3 {
    v - v.as_vec3().as_dvec3()
}

/// Constants that depend on the camera alone; the others are zero.
///
/// # Errors
/// [`Error::Limit`] for a view that is no rotation and a projection that is no perspective.
pub(crate) fn camera_constants(size: [u32; 2], input: &FrameInput) -> Result<Frame, Error> {
    let refused = |field, given: String, limit: &str| Err(Error::Limit { field, given, limit: limit.into() });
    let view = input.view_from_world;
    let off = (view * view.transpose() - DMat3::IDENTITY).to_cols_array();
    if !off.iter().all(|v| v.abs() < 1e-4) || !input.eye.is_finite() || !input.origin.is_finite() {
        let given = format!("{view} at {}", input.eye);
        return refused(
            "view_from_world",
            given,
            "three finite unit vectors at right angles, seen from a finite place",
        );
    }
    // a point of depth 1 lies at NDC (a x + b y - c) / w, w the same everywhere
    let [x, y, z, w] = [0, 1, 2, 3].map(|row| input.clip_from_view.row(row) / -input.clip_from_view.z_axis.w);
    let plane = DMat2::from_cols(DVec2::new(x.x, y.x), DVec2::new(x.y, y.y));
    let depth = [z.w, z.z];
    let perspective = input.clip_from_view.z_axis.w < 0.0 && [w.x, w.y, w.w, x.w, y.w, z.x, z.y] == [0.0; 7];
    let inverse = plane.inverse();
    if !perspective || !inverse.is_finite() || depth[0] == 0.0 || !depth.iter().all(|v| v.is_finite()) {
        let given = format!("{}", input.clip_from_view);
        return refused(
            "clip_from_view",
            given,
            "a perspective projection that looks along -z, depth of x and y alike",
        );
    }
    let middle = DVec2::new(x.z, y.z);
    let at = |ndc: DVec2| view.transpose() * (inverse * (ndc + middle)).extend(-1.0);
    let step = |ndc: DVec2| view.transpose() * (inverse * ndc).extend(0.0);
    let (width, height) = (f64::from(size[0]), f64::from(size[1]));
    let (dx, dy) = (step(DVec2::new(2.0 / width, 0.0)), step(DVec2::new(0.0, 2.0 / height)));
    let eye = input.eye - input.origin;
    let clip = (input.clip_from_view * DMat4::from_mat3(view)).as_mat4();
    Ok(Frame {
        clip_from_eye: clip.to_cols_array_2d(),
        ray_corner: word(at(DVec2::NEG_ONE), depth[0]),
        ray_dx: word(dx, depth[1]),
        ray_dy: word(dy, dy.length()),
        eye: word(eye, 0.0),
        eye_low: word(left(eye), 0.0),
        size: [size[0], size[1], 0, 0],
        ..Zeroable::zeroed()
    })
}

/// How far along the normal rays start: 1e-5 of the diagonal of the casters' bounds.
pub(crate) fn ray_start(scene: &SceneBuffers) -> f32 {
    (1e-5 * DVec3::from(scene.bounds_max).distance(scene.bounds_min.into())) as f32
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

/// All constants of a view's frame but those of its lights.
pub(crate) fn constants(
    config: &Config,
    size: [u32; 2],
    scene: &SceneBuffers,
    input: &FrameInput,
    history: &History,
) -> Result<Frame, Error> {
    let camera = camera_constants(size, input)?;
    Ok(Frame {
        size: [size[0], size[1], u32::from(config.level_rule == LevelRule::MinLength), 0],
        cache: [history.flags, history.frame, config.still_frames, history.page_cost],
        rule: [
            config.interior() as f32,
            config.bias_texels * config.filter.bias(),
            config.drift_texels,
            ray_start(scene),
        ],
        ..camera
    })
}

/// What the passes need of a light for an eye, relative to the scene's origin like the casters. `bias`: level bias.
pub(crate) fn light_record(
    config: &Config,
    scene: &SceneBuffers,
    light: &Light,
    input: &FrameInput,
    bias: f32,
) -> Result<LightRecord, Error> {
    let eye = input.eye - input.origin;
    let interior = f64::from(config.interior());
    // factor on the squared projected footprint of a pixel
    let squared = |units: f64| ((interior * units).powi(2) * (2.0 * f64::from(bias)).exp2()) as f32;
    // rounding of a coordinate: a few units in the last place of the largest
    let rounding = |largest: f64| (8.0 * f64::from(f32::EPSILON) * largest) as f32;
    let kind = |kind: u32| [kind, 0, 0, config.finest_level() as u32];
    let local = |kind_of: u32, axes: [DVec3; 3], position: DVec3, range: f64, tan: f64, cosine: f64| {
        let place = position - input.origin;
        let (low, high) = (DVec3::from(scene.bounds_min), DVec3::from(scene.bounds_max));
        let farthest = (low - place).abs().max((high - place).abs()).length().min(range);
        LightRecord {
            axis_x: word(axes[0] / tan, tan * tan),
            axis_y: word(axes[1] / tan, tan * tan),
            axis_z: word(axes[2], 0.0),
            low_x: [0.0; 4],
            low_y: [0.0; 4],
            place: word(place, range),
            place_low: word(left(place), 0.0),
            eye: word(eye - place, cosine),
            scale: [HALF as f32, 1.0 / HALF as f32, (farthest / RANGE_OVER_NEAR) as f32, 0.0],
            rule: [squared(f64::from(HALF)), rounding(place.length() + farthest), 0.0, 0.0],
            eye_page: [0; 4],
            kind: kind(kind_of),
        }
    };
    match light {
        Light::Directional { direction, .. } => {
            let grid = Grid::new(*direction, scene)?;
            let page = grid.half / f64::from(HALF);
            let units = DVec2::new(eye.dot(grid.axes[0]), eye.dot(grid.axes[1])) / page;
            let whole = units.floor();
            let inside = units - whole;
            let at = |v: f64| (v + f64::from(HALF)).clamp(-1e9, 1e9) as i32;
            Ok(LightRecord {
                axis_x: word(grid.axes[0], inside.x),
                axis_y: word(grid.axes[1], inside.y),
                low_x: word(left(grid.axes[0]), 0.0),
                low_y: word(left(grid.axes[1]), 0.0),
                axis_z: word(grid.axes[2], grid.reach - eye.dot(grid.axes[2])),
                scale: [(1.0 / page) as f32, page as f32, (0.5 / grid.reach) as f32, grid.reach as f32],
                rule: [squared(1.0 / page), rounding(2.0 * grid.reach), (grid.reach * interior / page) as f32, 0.0],
                eye_page: [at(whole.x), at(whole.y), 0, 0],
                kind: kind(light_kind::DIRECTIONAL),
                ..Zeroable::zeroed()
            })
        }
        Light::Spot { position, direction, outer_angle_deg, range, .. } => {
            let axes = light_axes(*direction)?;
            let outer = outer_angle_deg.to_radians();
            Ok(if *outer_angle_deg > WIDEST_FACE_DEG {
                local(light_kind::CUBE, axes, *position, *range, 1.0, outer.cos())
            } else {
                local(light_kind::SPOT, axes, *position, *range, outer.tan() * (1.0 + 1e-4), outer.cos())
            })
        }
        Light::Point { position, range } => {
            Ok(local(light_kind::CUBE, [DVec3::X, DVec3::Y, DVec3::Z], *position, *range, 1.0, -2.0))
        }
        Light::Area { .. } => Err(Error::Limit {
            field: "light",
            given: "an area light".into(),
            limit: "a directional, spot or point light without extent".into(),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Camera;
    use glam::{DVec4, Vec3};

    const SIZE: [u32; 2] = [640, 360];

    /// A point of the world is found again from where the projection puts it and the depth it stores.
    fn comes_back(name: &str, input: &FrameInput) {
        let frame = camera_constants(SIZE, input).unwrap();
        let xyz = |v: [f32; 4]| Vec3::new(v[0], v[1], v[2]).as_dvec3();
        for i in 0..200 {
            let share = |by: f64| (f64::from(i) * by).fract() - 0.5;
            let z = -(0.2 + 40.0 * share(0.31).abs());
            let view = DVec3::new(z * share(0.618), z * share(0.755), z);
            let clip = input.clip_from_view * view.extend(1.0);
            let ndc = clip / clip.w;
            let pixel = [0, 1].map(|k| (ndc[k] + 1.0) * 0.5 * f64::from(SIZE[k]));
            let ray = xyz(frame.ray_corner) + pixel[0] * xyz(frame.ray_dx) + pixel[1] * xyz(frame.ray_dy);
            let depth = f64::from(frame.ray_corner[3]) / (ndc.z + f64::from(frame.ray_dx[3]));
            let want = input.view_from_world.transpose() * view;
            assert!((ray * depth).distance(want) < 1e-4 * want.length(), "{name}: {} is not {want}", ray * depth);
        }
        let nearer = frame.ray_corner[3] > 0.0;
        let stored = |z: f64| {
            let clip = input.clip_from_view * DVec4::new(0.0, 0.0, z, 1.0);
            clip.z / clip.w
        };
        assert_eq!(stored(-1.0) > stored(-2.0), nearer, "{name}: which end is near");
    }

    fn camera() -> FrameInput {
        let (eye, target) = (DVec3::new(3.0, 2.0, -1.0), DVec3::new(0.0, 1.0, 4.0));
        let camera = Camera { eye, target, up: DVec3::Y, fov_y_deg: 60.0, near: 0.1, far: 100.0 };
        FrameInput::new(&camera, SIZE, DVec3::ZERO)
    }

    #[test]
    fn projections_of_every_kind() {
        let camera = camera();
        let with = |edit: fn(&mut DMat4)| {
            let mut input = camera;
            edit(&mut input.clip_from_view);
            input
        };
        comes_back("reversed", &camera);
        comes_back("reversed, to infinity", &with(|m| (m.z_axis.z, m.w_axis.z) = (0.0, 0.1)));
        comes_back("nearer is less", &with(|m| (m.z_axis.z, m.w_axis.z) = (-100.0 / 99.9, -10.0 / 99.9)));
        comes_back("off centre", &with(|m| (m.z_axis.x, m.z_axis.y) = (0.3, -0.05)));
        comes_back("y up", &with(|m| m.y_axis.y *= -1.0));
        comes_back("scaled", &with(|m| *m *= 3.0));
        let mut mirror = camera;
        mirror.view_from_world = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)) * mirror.view_from_world;
        comes_back("mirrored", &mirror);
    }

    #[test]
    fn cameras_that_are_none_are_refused() {
        let camera = camera();
        let mut bad = Vec::new();
        let clip = |edit: fn(&mut DMat4)| {
            let mut input = camera;
            edit(&mut input.clip_from_view);
            ("clip_from_view", input)
        };
        bad.push(clip(|m| *m = DMat4::IDENTITY));
        bad.push(clip(|m| m.x_axis.x = 0.0));
        bad.push(clip(|m| m.z_axis.w = 1.0));
        bad.push(clip(|m| m.w_axis.z = f64::NAN));
        bad.push(clip(|m| m.x_axis.z = 0.1));
        bad.push(("view_from_world", FrameInput { view_from_world: camera.view_from_world * 2.0, ..camera }));
        bad.push(("view_from_world", FrameInput { eye: DVec3::NAN, ..camera }));
        for (field, input) in bad {
            let error = camera_constants(SIZE, &input).unwrap_err().to_string();
            assert!(error.starts_with(field), "{error}");
        }
    }
}
