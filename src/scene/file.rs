//! The glTF container: JSON and buffers, from `.gltf` with its companions or from `.glb`.

use ::gltf::json::{Index, Root, buffer, deserialize};
use std::path::{Path, PathBuf};

/// Required extensions that change nothing here, besides everything called `KHR_materials_*`.
const EXTENSIONS: [&str; 4] =
    ["KHR_texture_transform", "KHR_mesh_quantization", "KHR_lights_punctual", "KHR_xmp_json_ld"];

/// The parsed JSON with all buffers in memory. Nothing in `root` has been validated.
pub(super) struct File {
    pub(super) root: Root,
    buffers: Vec<Vec<u8>>,
    folder: PathBuf,
}

impl File {
    /// Reads the file and every buffer it names.
    pub(super) fn open(path: &Path) -> Result<Self, String> {
        let bytes = std::fs::read(path).map_err(|e| format!("the file cannot be read ({e})"))?;
        let (text, blob) = if bytes.starts_with(b"glTF") { split_glb(&bytes)? } else { (&bytes[..], None) };
        let root: Root = deserialize::from_slice(text).map_err(|e| format!("the JSON is malformed ({e})"))?;
        if !root.asset.version.starts_with("2.") {
            return Err(format!("asset.version is `{}`; only 2.x is supported", root.asset.version));
        }
        if let Some(name) = root.extensions_required.iter().find(|name| !is_supported(name)) {
            return Err(format!("the file requires the extension `{name}`, which is not supported"));
        }
        let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
        let mut file = Self { root, buffers: Vec::new(), folder };
        file.buffers = (0..file.root.buffers.len()).map(|i| file.read_buffer(i, blob)).collect::<Result<_, _>>()?;
        Ok(file)
    }

    fn read_buffer(&self, index: usize, blob: Option<&[u8]>) -> Result<Vec<u8>, String> {
        let buffer = &self.root.buffers[index];
        let mut bytes = match &buffer.uri {
            Some(uri) => self.read_uri(uri).map_err(|e| format!("buffer {index} {e}"))?,
            None if index == 0 => {
                blob.map(<[u8]>::to_vec).ok_or("buffer 0 has no uri and the file has no BIN chunk")?
            }
            None => return Err(format!("buffer {index} has no uri; only buffer 0 may be the BIN chunk")),
        };
        let wanted = buffer.byte_length.0;
        if (bytes.len() as u64) < wanted {
            return Err(format!("buffer {index} holds {} bytes but its byteLength is {wanted}", bytes.len()));
        }
        bytes.truncate(wanted as usize);
        Ok(bytes)
    }

    /// The bytes behind a data URI or a file name relative to the glTF file. The error continues a sentence.
    pub(super) fn read_uri(&self, uri: &str) -> Result<Vec<u8>, String> {
        if let Some(data) = uri.strip_prefix("data:") {
            let (kind, data) = data.split_once(',').ok_or("has a data URI without a comma")?;
            return match kind.ends_with(";base64") {
                true => base64(data.as_bytes()).ok_or_else(|| "has a data URI with malformed base64".to_string()),
                false => Ok(percent(data)),
            };
        }
        if uri.contains("://") {
            return Err(format!("is at `{uri}`; only files and data URIs can be read"));
        }
        let name = String::from_utf8(percent(uri)).map_err(|_| format!("has the name `{uri}`, which is not UTF-8"))?;
        std::fs::read(self.folder.join(&name))
            .map_err(|e| format!("names the file `{name}`, which cannot be read ({e})"))
    }

    /// The bytes of a buffer view.
    pub(super) fn view(&self, index: Index<buffer::View>) -> Result<&[u8], String> {
        let i = index.value();
        let view = find(&self.root.buffer_views, i, "buffer view")?;
        let bytes = find(&self.buffers, view.buffer.value(), "buffer")?;
        let start = view.byte_offset.unwrap_or_default().0;
        let length = view.byte_length.0;
        start
            .checked_add(length)
            .and_then(|end| bytes.get(usize::try_from(start).ok()?..usize::try_from(end).ok()?))
            .ok_or_else(|| {
                let buffer = view.buffer;
                let held = bytes.len();
                format!("buffer view {i} covers {length} bytes from {start} but buffer {buffer} holds {held}")
            })
    }

    /// Size of all buffers, an upper limit for any honest element count.
    pub(super) fn buffer_bytes(&self) -> u64 {
        self.buffers.iter().map(|b| b.len() as u64).sum()
    }
}

/// The element, or a sentence that names the index and the number there are.
pub(super) fn find<'a, T>(list: &'a [T], index: usize, what: &str) -> Result<&'a T, String> {
    list.get(index).ok_or_else(|| format!("{what} {index} is named but the file has {}", list.len()))
}

/// `mesh 3` or ``mesh 3 `name` ``.
pub(super) fn label(what: &str, index: usize, name: Option<&String>) -> String {
    match name {
        Some(name) => format!("{what} {index} `{name}`"),
        None => format!("{what} {index}"),
    }
}

fn is_supported(extension: &str) -> bool {
    extension.starts_with("KHR_materials_") || EXTENSIONS.contains(&extension)
}

/// JSON text and BIN chunk of a `.glb`.
fn split_glb(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    let held = bytes.len();
    let (Some(version), Some(length)) = (word(bytes, 4), word(bytes, 8)) else {
        return Err(format!("the GLB header is cut off: {held} bytes of 12"));
    };
    if version != 2 {
        return Err(format!("the GLB version is {version}; only 2 is supported"));
    }
    let bytes = bytes
        .get(..length as usize)
        .ok_or_else(|| format!("the GLB header says {length} bytes but the file holds {held}"))?;
    let (json, rest) = split_chunk(bytes.get(12..).unwrap_or_default(), *b"JSON")?;
    let text = json.ok_or("the GLB does not start with a JSON chunk")?;
    let (blob, _) = split_chunk(rest, *b"BIN\0")?;
    Ok((text, blob))
}

/// The first chunk, if there is one of this kind, and what follows it.
fn split_chunk(bytes: &[u8], kind: [u8; 4]) -> Result<(Option<&[u8]>, &[u8]), String> {
    if bytes.is_empty() {
        return Ok((None, bytes));
    }
    let (Some(length), Some(found)) = (word(bytes, 0), bytes.get(4..8)) else {
        return Err(format!("a GLB chunk header is cut off: {} bytes of 8", bytes.len()));
    };
    let (body, rest) = bytes[8..]
        .split_at_checked(length as usize)
        .ok_or_else(|| format!("a GLB chunk of {length} bytes has only {} left", bytes.len() - 8))?;
    Ok(((found == kind).then_some(body), rest))
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..at + 4)?.try_into().ok().map(u32::from_le_bytes)
}

/// RFC 4648 base64; padding and white space are skipped.
fn base64(text: &[u8]) -> Option<Vec<u8>> {
    let mut out = Vec::with_capacity(text.len() / 4 * 3);
    let (mut bits, mut count) = (0u32, 0);
    for &c in text.iter().filter(|c| !c.is_ascii_whitespace() && **c != b'=') {
        let value = match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            _ => return None,
        };
        bits = bits << 6 | u32::from(value);
        count += 6;
        if count >= 8 {
            count -= 8;
            out.push((bits >> count) as u8);
        }
    }
    (count < 6).then_some(out)
}

/// Undoes `%20`-style escapes; anything else is kept.
fn percent(text: &str) -> Vec<u8> {
    let bytes = text.as_bytes();
    let mut out = Vec::with_capacity(bytes.len());
    let mut i = 0;
    while i < bytes.len() {
        let hex = bytes.get(i + 1..i + 3).and_then(|h| Some((nibble(h[0])?, nibble(h[1])?)));
        match (bytes[i], hex) {
            (b'%', Some((high, low))) => {
                out.push(high << 4 | low);
                i += 3;
            }
            (other, _) => {
                out.push(other);
                i += 1;
            }
        }
    }
    out
}

fn nibble(c: u8) -> Option<u8> {
    (c as char).to_digit(16).map(|d| d as u8)
}
