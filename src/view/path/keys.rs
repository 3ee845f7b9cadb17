//! A camera path from a file: `{"keys":[{"frame":0,"eye":[0,1,5],"target":[0,1,0],"fov_y_deg":60}]}`.

use super::super::{DEPTH_RANGE, ViewError, read, require};
use crate::Camera;
use serde::Deserialize;
use std::path::Path;

/// Keys of a camera, as read: linear between them, standing before the first and after the last. Without `fov_y_deg` a key
/// has the field of view of the base view, whose up direction all frames have.
#[derive(Debug, Clone, PartialEq)]
pub struct PathFile {
    name: String,
    keys: Vec<Key>,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct PathJson {
    keys: Vec<Key>,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Key {
    frame: u32,
    eye: [f64; 3],
    target: [f64; 3],
    fov_y_deg: Option<f64>,
}

impl PathFile {
    /// Reads and checks a path file.
    pub fn read(path: &Path) -> Result<Self, ViewError> {
        read(path, Self::parse)
    }

    /// Reads and checks the text of a path file; `name` is for the error.
    pub fn parse(name: &str, text: &str) -> Result<Self, ViewError> {
        let fail = |what| ViewError { file: name.to_owned(), what };
        let json: PathJson = serde_json::from_str(text).map_err(|e| fail(format!("is no camera path: {e}")))?;
        check(&json.keys).map_err(fail)?;
        Ok(Self { name: name.to_owned(), keys: json.keys })
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    pub(super) fn pose(&self, base: &Camera, frame: u32) -> Camera {
        let next = self.keys.partition_point(|key| key.frame <= frame);
        let last = self.keys.len() - 1;
        let (a, b) = (&self.keys[next.saturating_sub(1)], &self.keys[next.min(last)]);
        let span = f64::from(b.frame.saturating_sub(a.frame).max(1));
        let share = f64::from(frame.saturating_sub(a.frame)) / span;
        let mix = |a: f64, b: f64| a + (b - a) * share.min(1.0);
        let point = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|k| mix(a[k], b[k])).into();
        let fov = |key: &Key| key.fov_y_deg.unwrap_or(base.fov_y_deg);
        Camera { eye: point(a.eye, b.eye), target: point(a.target, b.target), fov_y_deg: mix(fov(a), fov(b)), ..*base }
    }
}

fn check(keys: &[Key]) -> Result<(), String> {
    require(!keys.is_empty(), "keys", "empty", "at least one key")?;
    for (k, key) in keys.iter().enumerate() {
        let allowed = format!("three numbers within {:e}", DEPTH_RANGE[1]);
        for (field, point) in [("eye", key.eye), ("target", key.target)] {
            let near = point.iter().all(|v| v.abs() <= DEPTH_RANGE[1]);
            require(near, &format!("keys[{k}].{field}"), format_args!("{point:?}"), &allowed)?;
        }
        let different = format!("a point other than the eye {:?}", key.eye);
        require(key.eye != key.target, &format!("keys[{k}].target"), format_args!("{:?}", key.target), &different)?;
        if let Some(fov) = key.fov_y_deg {
            let field = format!("keys[{k}].fov_y_deg");
            require(fov > 0.0 && fov < 180.0, &field, fov, "above 0 and below 180 degrees")?;
        }
    }
    for (k, pair) in keys.windows(2).enumerate() {
        let (before, frame) = (pair[0].frame, pair[1].frame);
        let allowed = format!("above the {before} of the key before it");
        require(frame > before, &format!("keys[{}].frame", k + 1), frame, &allowed)?;
    }
    Ok(())
}
