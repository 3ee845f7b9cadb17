//! Files and pictures: lossless EXR, PNG, shaded and false-colour images. Every file appears whole or not at all.

#![forbid(unsafe_code)]

mod atomic;
#[cfg(feature = "cli")]
mod axis;
mod exr;
pub(crate) mod false_color;
pub(crate) mod font;
mod picture;
#[cfg(feature = "cli")]
mod plot;
mod png;
pub(crate) mod shade;

pub use atomic::write_file;
#[cfg(feature = "cli")]
pub use axis::Scale;
pub use exr::{ExrImage, read_exr, write_exr};
pub use false_color::{factors, ids, levels};
pub use picture::{DIFFERENCE_LEGEND, Picture, side_by_side};
#[cfg(feature = "cli")]
pub use plot::{Chart, Line, draw_svg, write_svg};
pub use png::{encode_png, write_png};
pub use shade::{difference, shade};

use std::path::Path;

/// A file that cannot be written or read, or a picture whose inputs do not fit.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{path}: {what}")]
pub struct OutputError {
    /// The file as it was named, or the picture's name when there is no file.
    pub path: String,
    /// The cause in one clause.
    pub what: String,
}

impl OutputError {
    fn new(path: &Path, what: impl ToString) -> Self {
        Self { path: path.display().to_string(), what: what.to_string() }
    }

    /// An image list with a wrong number of pixels.
    fn size(name: &str, given: usize, width: u32, height: u32) -> Self {
        Self { path: name.to_owned(), what: format!("{given} pixels were given, {width}x{height} above 0 are needed") }
    }
}
