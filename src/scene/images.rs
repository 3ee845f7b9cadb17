//! Base-colour images, decoded once each and packed one after another.

use super::file::{File, find, label};
use ::gltf::json::texture::Texture;
use ::gltf::json::{Image as Json, Index};
use image::{ImageReader, Limits};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::io::Cursor;
use std::sync::atomic::{AtomicU64, Ordering};

/// Longest side of an image whose alpha decides nothing.
const OPAQUE_SIDE: u32 = 512;
/// Longest side that is decoded at all.
const MAX_SIDE: u32 = 16384;
/// Most texels of a scene: 120 MiB.
const MAX_TEXELS: u64 = 120 * 1024 * 1024 / 4;

/// One decoded image.
pub(super) struct Image {
    pub(super) width: u32,
    pub(super) height: u32,
    /// RGBA8, R in the lowest byte.
    texels: Vec<u32>,
    /// Smallest and largest alpha, 0 to 1.
    pub(super) alpha: [f32; 2],
    /// Whether the image may be stored smaller.
    shrinks: bool,
    /// First texel in the packed array; valid after [`Images::pack`].
    pub(super) offset: u32,
}

/// The images a scene uses, by their index in the file.
#[derive(Default)]
pub(super) struct Images(pub(super) BTreeMap<usize, Image>);

impl Images {
    /// Decodes images; the flag says whether their alpha is tested, which keeps them at full size.
    pub(super) fn decode(file: &File, wanted: &BTreeMap<usize, bool>) -> Result<Self, String> {
        let kept = AtomicU64::new(0);
        let decode = |(&index, &tested): (&usize, &bool)| {
            let json = find(&file.root.images, index, "image")?;
            let image =
                decode(file, json, tested).map_err(|e| format!("{} {e}", label("image", index, json.name.as_ref())))?;
            // stops before many large images fill the memory; `pack` sees the final sum
            let kept = kept.fetch_add(image.unshrinkable(), Ordering::Relaxed) + image.unshrinkable();
            match kept <= MAX_TEXELS {
                true => Ok((index, image)),
                false => Err(too_large()),
            }
        };
        Ok(Self(wanted.par_iter().map(decode).collect::<Result<_, String>>()?))
    }

    /// Lays all images one after another, shrinking those without tested alpha as far as the limit demands.
    pub(super) fn pack(&mut self) -> Result<Vec<u32>, String> {
        let total = |images: &BTreeMap<usize, Image>| images.values().map(|i| i.texels.len() as u64).sum::<u64>();
        let mut side = OPAQUE_SIDE;
        while total(&self.0) > MAX_TEXELS && side > 1 {
            side /= 2;
            self.0.values_mut().filter(|i| i.shrinks).for_each(|i| i.shrink(side));
        }
        let held = total(&self.0);
        if held > MAX_TEXELS {
            return Err(too_large());
        }
        let mut packed = Vec::with_capacity(held as usize);
        for image in self.0.values_mut() {
            image.offset = packed.len() as u32;
            packed.append(&mut image.texels);
        }
        Ok(packed)
    }
}

fn too_large() -> String {
    format!("the images whose alpha is tested take more than {MAX_TEXELS} texels, the most that fit")
}

impl Image {
    /// Texels that must be stored at full size.
    fn unshrinkable(&self) -> u64 {
        if self.shrinks { 0 } else { self.texels.len() as u64 }
    }

    /// Averages boxes of stored values until no side is longer than `side`.
    fn shrink(&mut self, side: u32) {
        let longest = self.width.max(self.height);
        if longest <= side {
            return;
        }
        let scale = |length: u32| (u64::from(length) * u64::from(side)).div_ceil(u64::from(longest)) as u32;
        let (width, height) = (scale(self.width), scale(self.height));
        let mut texels = Vec::with_capacity(width as usize * height as usize);
        for y in 0..height {
            let rows = span(y, height, self.height);
            for x in 0..width {
                texels.push(self.average(span(x, width, self.width), rows.clone()));
            }
        }
        (self.width, self.height, self.texels) = (width, height, texels);
    }

    fn average(&self, columns: std::ops::Range<u32>, rows: std::ops::Range<u32>) -> u32 {
        let mut sum = [0u32; 4];
        for y in rows.clone() {
            for x in columns.clone() {
                let texel = self.texels[(y * self.width + x) as usize].to_le_bytes();
                sum.iter_mut().zip(texel).for_each(|(s, t)| *s += u32::from(t));
            }
        }
        let count = (columns.len() * rows.len()) as u32;
        u32::from_le_bytes(sum.map(|s| ((s + count / 2) / count) as u8))
    }
}

/// Source texels of a smaller image's texel: the ranges tile the source and none is empty.
fn span(i: u32, small: u32, large: u32) -> std::ops::Range<u32> {
    let edge = |i: u32| (u64::from(i) * u64::from(large) / u64::from(small)) as u32;
    edge(i)..edge(i + 1)
}

/// Image index of a texture; `None` where only an unknown extension names one.
pub(super) fn source(file: &File, texture: Index<Texture>) -> Result<Option<usize>, String> {
    let source = find(&file.root.textures, texture.value(), "texture")?.source.value();
    Ok((source != u32::MAX as usize).then_some(source))
}

/// The error continues a sentence that names the image.
fn decode(file: &File, json: &Json, tested: bool) -> Result<Image, String> {
    let loaded;
    let bytes = match (json.buffer_view, &json.uri) {
        (Some(view), _) => file.view(view).map_err(|e| format!("cannot be read: {e}"))?,
        (None, Some(uri)) => {
            loaded = file.read_uri(uri)?;
            &loaded[..]
        }
        (None, None) => return Err("has neither a buffer view nor a uri".to_string()),
    };
    let fail = |e: &dyn std::fmt::Display| format!("cannot be decoded ({e}); PNG and JPEG are supported");
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| fail(&e))?;
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    reader.limits(limits);
    let pixels = reader.decode().map_err(|e| fail(&e))?.into_rgba8();
    let (width, height) = pixels.dimensions();
    if width == 0 || height == 0 {
        return Err(format!("is {width}x{height} texels; both sides must be at least 1"));
    }
    let texels: Vec<u32> = pixels.as_raw().as_chunks::<4>().0.iter().map(|p| u32::from_le_bytes(*p)).collect();
    let (low, high) = texels.iter().fold((255, 0), |(low, high), t| (low.min(t >> 24), high.max(t >> 24)));
    let alpha = [low as f32 / 255.0, high as f32 / 255.0];
    // alpha of 1 throughout stays so under averaging
    let shrinks = !tested || low == 255;
    let mut image = Image { width, height, texels, alpha, shrinks, offset: 0 };
    if shrinks {
        image.shrink(OPAQUE_SIDE);
    }
    Ok(image)
}
