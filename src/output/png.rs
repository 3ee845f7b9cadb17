//! PNG files, 8 bits a channel, sRGB.

use super::{OutputError, Picture, write_file};
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use std::path::Path;

/// The bytes of a PNG file.
///
/// Fails when the picture's bytes do not match its size or it has no pixel.
pub fn encode_png(picture: &Picture) -> Result<Vec<u8>, OutputError> {
    let Picture { width, height, rgb } = picture;
    if rgb.is_empty() || rgb.len() != 3 * *width as usize * *height as usize {
        return Err(OutputError::size("picture", rgb.len() / 3, *width, *height));
    }
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes)
        .write_image(rgb, *width, *height, ExtendedColorType::Rgb8)
        .map_err(|e| OutputError { path: "picture".to_owned(), what: e.to_string() })?;
    Ok(bytes)
}

/// Writes `picture` to `path`.
///
/// Fails when the picture's bytes do not match its size, it has no pixel, or the file cannot be written.
pub fn write_png(path: &Path, picture: &Picture) -> Result<(), OutputError> {
    let bytes = encode_png(picture).map_err(|e| OutputError::new(path, e.what))?;
    write_file(path, &bytes)
}
