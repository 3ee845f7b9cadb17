//! `view.json`: camera, lights, image size and time as a file. What a file leaves out is taken from the scene.

mod choose;
mod lights;
mod path;

pub use lights::MAX_SYNTHETIC_LIGHTS;
pub use path::{CameraPath, PATH_NAMES, PathFile, Surroundings, median_distance};

use crate::lab::View;
use crate::scene::Scene;
use crate::{Camera, Light};
use glam::DVec3;
use serde::{Deserialize, Serialize, Serializer};
use std::fmt::Display;
use std::path::Path;

/// Size of the image when neither the caller nor the view file names one, in pixels.
pub const DEFAULT_SIZE: [u32; 2] = [1280, 720];
/// Longest side of an image in pixels: what every Vulkan device that runs the engine can draw into.
pub const MAX_SIDE: u32 = 16384;
/// Bounds of the depth range; beyond them the projection leaves what single precision holds.
const DEPTH_RANGE: [f64; 2] = [1e-9, 1e12];
/// Near plane over the diagonal of the scene, where the file names none.
const NEAR_OVER_DIAGONAL: f64 = 1e-4;

/// A view file that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{file}: {what}")]
pub struct ViewError {
    /// The file as it was named.
    pub file: String,
    /// Field, value and what is allowed, in one clause.
    pub what: String,
}

/// A view file as read: valid, but perhaps without the fields that depend on the scene.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewFile {
    name: String,
    json: ViewJson,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ViewJson {
    camera: CameraJson,
    lights: Vec<LightJson>,
    size: Option<[u32; 2]>,
    #[serde(default)]
    time_s: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraJson {
    eye: DVec3Json,
    target: DVec3Json,
    #[serde(default = "up")]
    up: DVec3Json,
    fov_y_deg: f64,
    near: Option<f64>,
    far: Option<f64>,
}

type DVec3Json = [f64; 3];

fn up() -> DVec3Json {
    DVec3::Y.to_array()
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
enum LightJson {
    Directional {
        direction: DVec3Json,
        #[serde(default)]
        angular_diameter_deg: f64,
    },
    Spot {
        position: DVec3Json,
        direction: DVec3Json,
        #[serde(default)]
        inner_angle_deg: f64,
        outer_angle_deg: f64,
        range: f64,
    },
    Point {
        position: DVec3Json,
        range: f64,
    },
    Area {
        polygon: Vec<DVec3Json>,
    },
}

/// Reads a file and gives its name and text to `parse`.
fn read<T>(path: &Path, parse: impl FnOnce(&str, &str) -> Result<T, ViewError>) -> Result<T, ViewError> {
    let name = path.display().to_string();
    match std::fs::read_to_string(path) {
        Ok(text) => parse(&name, &text),
        Err(error) => Err(ViewError { file: name, what: format!("cannot be read: {error}") }),
    }
}

impl ViewFile {
    /// Reads and checks a view file.
    pub fn read(path: &Path) -> Result<Self, ViewError> {
        read(path, Self::parse)
    }

    /// Reads and checks the text of a view file; `name` is for the error.
    pub fn parse(name: &str, text: &str) -> Result<Self, ViewError> {
        let fail = |what| ViewError { file: name.to_owned(), what };
        let json: ViewJson = serde_json::from_str(text).map_err(|e| fail(format!("is no view: {e}")))?;
        json.check().map_err(fail)?;
        Ok(Self { name: name.to_owned(), json })
    }

    /// Time at which animations are posed, in seconds; needed before the scene is loaded.
    pub fn time_s(&self) -> f64 {
        self.json.time_s
    }

    /// Fills in what the file leaves out. `size` wins over the file's size.
    pub fn complete(&self, scene: &Scene, size: Option<[u32; 2]>) -> Result<View, ViewError> {
        let c = &self.json.camera;
        let mut camera = Camera {
            eye: c.eye.into(),
            target: c.target.into(),
            up: c.up.into(),
            fov_y_deg: c.fov_y_deg,
            near: 0.0,
            far: 0.0,
        };
        let [near, far] = depth_range(&camera, scene);
        // a plane that the file names moves the other one out of its way
        camera.near = c.near.unwrap_or_else(|| c.far.map_or(near, |far| near.min(far * NEAR_OVER_DIAGONAL)));
        camera.far = c.far.unwrap_or_else(|| far.max(camera.near * 2.0));
        let view = View {
            camera,
            lights: self.json.lights.iter().map(LightJson::light).collect(),
            size: size.or(self.json.size).unwrap_or(DEFAULT_SIZE),
            time_s: self.json.time_s,
        };
        view.check().map_err(|what| ViewError { file: self.name.clone(), what })?;
        Ok(view)
    }
}

impl View {
    /// A view of the whole scene from outside, or from inside where the outside shows nothing but walls.
    pub fn default_for(scene: &Scene, size: [u32; 2]) -> View {
        choose::view(scene, size)
    }

    /// The view as a complete `view.json`.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(self).map(|text| text + "\n")
    }

    /// Says which field is not allowed, in one clause; a view made by hand should pass this before use.
    pub fn check(&self) -> Result<(), String> {
        ViewJson::from(self).check()
    }
}

impl Serialize for View {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        ViewJson::from(self).serialize(serializer)
    }
}

impl From<&View> for ViewJson {
    fn from(view: &View) -> Self {
        let camera = &view.camera;
        Self {
            camera: CameraJson {
                eye: camera.eye.to_array(),
                target: camera.target.to_array(),
                up: camera.up.to_array(),
                fov_y_deg: camera.fov_y_deg,
                near: Some(camera.near),
                far: Some(camera.far),
            },
            lights: view.lights.iter().map(LightJson::of).collect(),
            size: Some(view.size),
            time_s: view.time_s,
        }
    }
}

impl LightJson {
    fn light(&self) -> Light {
        match self {
            Self::Directional { direction, angular_diameter_deg } => {
                Light::Directional { direction: (*direction).into(), angular_diameter_deg: *angular_diameter_deg }
            }
            Self::Spot { position, direction, inner_angle_deg, outer_angle_deg, range } => Light::Spot {
                position: (*position).into(),
                direction: (*direction).into(),
                inner_angle_deg: *inner_angle_deg,
                outer_angle_deg: *outer_angle_deg,
                range: *range,
            },
            Self::Point { position, range } => Light::Point { position: (*position).into(), range: *range },
            Self::Area { polygon } => Light::Area { polygon: polygon.iter().map(|&p| p.into()).collect() },
        }
    }

    fn of(light: &Light) -> Self {
        match light {
            Light::Directional { direction, angular_diameter_deg } => {
                Self::Directional { direction: direction.to_array(), angular_diameter_deg: *angular_diameter_deg }
            }
            Light::Spot { position, direction, inner_angle_deg, outer_angle_deg, range } => Self::Spot {
                position: position.to_array(),
                direction: direction.to_array(),
                inner_angle_deg: *inner_angle_deg,
                outer_angle_deg: *outer_angle_deg,
                range: *range,
            },
            Light::Point { position, range } => Self::Point { position: position.to_array(), range: *range },
            Light::Area { polygon } => Self::Area { polygon: polygon.iter().map(DVec3::to_array).collect() },
        }
    }

    fn check(&self, index: usize) -> Result<(), String> {
        match self {
            Self::Directional { direction, angular_diameter_deg } => {
                check_direction(index, direction)?;
                let field = format!("lights[{index}].angular_diameter_deg");
                require((0.0..180.0).contains(angular_diameter_deg), &field, angular_diameter_deg, "0 to below 180")
            }
            Self::Spot { position, direction, inner_angle_deg, outer_angle_deg, range } => {
                check_place(index, position, *range)?;
                check_direction(index, direction)?;
                let field = format!("lights[{index}].outer_angle_deg");
                let outer = *outer_angle_deg;
                require(outer > 0.0 && outer <= 90.0, &field, outer, "above 0 and up to 90 degrees from the axis")?;
                let field = format!("lights[{index}].inner_angle_deg");
                let allowed = format!("0 to outer_angle_deg ({outer:?})");
                require((0.0..=outer).contains(inner_angle_deg), &field, inner_angle_deg, &allowed)
            }
            Self::Point { position, range } => check_place(index, position, *range),
            Self::Area { polygon } => {
                let field = format!("lights[{index}].polygon");
                require(polygon.len() >= 3, &field, format_args!("{} corners", polygon.len()), "at least 3 corners")?;
                let finite = polygon.iter().flatten().all(|v| v.is_finite());
                require(finite, &field, format_args!("{polygon:?}"), "finite corners")
            }
        }
    }
}

/// Direction of a light.
fn check_direction(index: usize, direction: &DVec3Json) -> Result<(), String> {
    let (field, allowed) = (format!("lights[{index}].direction"), "a finite vector of a length other than 0");
    require(has_length((*direction).into()), &field, format_args!("{direction:?}"), allowed)
}

/// Position and range of a light at a point.
fn check_place(index: usize, position: &DVec3Json, range: f64) -> Result<(), String> {
    let most = DEPTH_RANGE[1];
    let field = format!("lights[{index}].position");
    let allowed = format!("three numbers within {most:e}");
    require(position.iter().all(|v| v.abs() <= most), &field, format_args!("{position:?}"), &allowed)?;
    let field = format!("lights[{index}].range");
    require(range > 0.0 && range <= most, &field, range, &format!("above 0 and up to {most:e}"))
}

impl ViewJson {
    fn check(&self) -> Result<(), String> {
        self.camera.check()?;
        require(!self.lights.is_empty(), "lights", "empty", "at least one light")?;
        for (index, light) in self.lights.iter().enumerate() {
            light.check(index)?;
        }
        if let Some(size) = self.size {
            let allowed = format!("1 to {MAX_SIDE} pixels a side");
            require(size.iter().all(|side| (1..=MAX_SIDE).contains(side)), "size", format_args!("{size:?}"), &allowed)?;
        }
        require(self.time_s.is_finite(), "time_s", self.time_s, "a finite number of seconds")
    }
}

impl CameraJson {
    fn check(&self) -> Result<(), String> {
        let (eye, target, up) = (DVec3::from(self.eye), DVec3::from(self.target), DVec3::from(self.up));
        for (field, point) in [("camera.eye", self.eye), ("camera.target", self.target)] {
            let allowed = format!("three numbers within {:e}", DEPTH_RANGE[1]);
            require(point.iter().all(|v| v.abs() <= DEPTH_RANGE[1]), field, format_args!("{point:?}"), &allowed)?;
        }
        let different = format!("a point other than the eye {:?}", self.eye);
        require(has_length(target - eye), "camera.target", format_args!("{:?}", self.target), &different)?;
        let slanted = "a finite vector of a length other than 0 that is not parallel to the view direction";
        let sine = up.normalize_or_zero().cross((target - eye).normalize_or_zero()).length();
        require(has_length(up) && sine > 1e-6, "camera.up", format_args!("{:?}", self.up), slanted)?;
        let fov = self.fov_y_deg;
        require(fov > 0.0 && fov < 180.0, "camera.fov_y_deg", fov, "above 0 and below 180 degrees")?;
        let [least, most] = DEPTH_RANGE;
        if let Some(near) = self.near {
            require((least..most).contains(&near), "camera.near", near, &format!("{least:e} to below {most:e}"))?;
        }
        if let Some(far) = self.far {
            let above = self.near.unwrap_or(least);
            require(
                far > above && far <= most,
                "camera.far",
                far,
                &format!("above near ({above:?}) and up to {most:e}"),
            )?;
        }
        Ok(())
    }
}

fn require(holds: bool, field: &str, given: impl Display, allowed: &str) -> Result<(), String> {
    if holds { Ok(()) } else { Err(format!("{field} is {given}, allowed is {allowed}")) }
}

/// Whether a vector can be normalized.
fn has_length(v: DVec3) -> bool {
    let length = v.length();
    length > 0.0 && length.is_finite() && length.recip().is_finite()
}

/// Near and far plane that hold the whole scene as seen by `camera`, whose own planes are not looked at.
fn depth_range(camera: &Camera, scene: &Scene) -> [f64; 2] {
    let forward = (camera.target - camera.eye).normalize();
    let diagonal = scene.diagonal().max(1e-4);
    let near = (diagonal * NEAR_OVER_DIAGONAL).max(DEPTH_RANGE[0]);
    let deepest = corners(scene).map(|corner| (corner - camera.eye).dot(forward)).fold(0.0, f64::max);
    [near, (deepest * 1.01).max(near * 2.0).min(DEPTH_RANGE[1])]
}

/// The corners of the scene's bounds.
fn corners(scene: &Scene) -> impl Iterator<Item = DVec3> {
    let (low, high) = (scene.bounds_min, scene.bounds_max);
    (0..8).map(move |i| DVec3::select(glam::BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0), high, low))
}
