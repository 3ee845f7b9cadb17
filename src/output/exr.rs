//! OpenEXR files with float32 channels, compressed without loss.

use super::{OutputError, write_file};
use ::exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes, LineOrder,
    ReadChannels, ReadLayers, Text, Vec2, WritableImage, read,
};
use std::io::Cursor;
use std::path::Path;

/// What [`read_exr`] returns.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ExrImage {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Name and values of each channel, sorted by name, row 0 at the top.
    pub channels: Vec<(String, Vec<f32>)>,
}

impl ExrImage {
    /// The values of the channel called `name`.
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        self.channels.iter().find(|(n, _)| n == name).map(|(_, values)| values.as_slice())
    }
}

/// Writes `channels` (name, one value a pixel, row 0 at the top) as float32 with ZIP compression, 16 rows a block.
///
/// Fails when there is no pixel or channel, a list has another length, a name is empty, not ASCII or given twice, or the
/// file cannot be written.
pub fn write_exr(path: &Path, width: u32, height: u32, channels: &[(&str, &[f32])]) -> Result<(), OutputError> {
    let pixels = width as usize * height as usize;
    if channels.is_empty() {
        return Err(OutputError::new(path, "no channel was given"));
    }
    let mut list = Vec::with_capacity(channels.len());
    for (k, (name, values)) in channels.iter().enumerate() {
        if values.len() != pixels || pixels == 0 {
            let what = format!("channel {name} has {} values, {width}x{height} above 0 are needed", values.len());
            return Err(OutputError::new(path, what));
        }
        if channels[..k].iter().any(|(other, _)| other == name) {
            return Err(OutputError::new(path, format!("channel {name} was given twice")));
        }
        let text = Text::new_or_none(name).filter(|_| !name.is_empty() && name.is_ascii());
        let text = text.ok_or_else(|| OutputError::new(path, format!("\"{name}\" is not a channel name")))?;
        list.push(AnyChannel::new(text, FlatSamples::F32(values.to_vec())));
    }
    let encoding =
        Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let size = Vec2(width as usize, height as usize);
    let layer = Layer::new(size, LayerAttributes::default(), encoding, AnyChannels::sort(list.into_iter().collect()));
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut bytes).map_err(|e| OutputError::new(path, e))?;
    write_file(path, bytes.get_ref())
}

/// Reads all channels of the first layer of `path`; half and integer samples become float32.
pub fn read_exr(path: &Path) -> Result<ExrImage, OutputError> {
    let bytes = std::fs::read(path).map_err(|e| OutputError::new(path, e))?;
    let reader = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let image = reader.from_buffered(Cursor::new(bytes)).map_err(|e| OutputError::new(path, e))?;
    let layer = image.layer_data;
    let channels =
        layer.channel_data.list.iter().map(|c| (c.name.to_string(), c.sample_data.values_as_f32().collect()));
    Ok(ExrImage { width: layer.size.width() as u32, height: layer.size.height() as u32, channels: channels.collect() })
}
