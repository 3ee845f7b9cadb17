//! Small glTF files made in a test: JSON and one binary buffer.

use serde_json::{Value, json};
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

/// Component types of glTF.
pub const I16: u32 = 5122;
pub const U8: u32 = 5121;
pub const U16: u32 = 5123;
pub const U32: u32 = 5125;
pub const F32: u32 = 5126;

/// A document under construction; `json` may be edited freely before it is written.
pub struct Doc {
    pub json: Value,
    pub bin: Vec<u8>,
}

impl Doc {
    pub fn new() -> Self {
        let json = json!({
            "asset": {"version": "2.0"}, "accessors": [], "bufferViews": [], "meshes": [], "nodes": [],
            "materials": [], "textures": [], "images": [], "samplers": [], "skins": [], "animations": [],
        });
        Self { json, bin: Vec::new() }
    }

    /// Appends to a top-level list; returns the index.
    pub fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.json[list].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let offset = self.bin.len();
        self.bin.extend_from_slice(bytes);
        self.push("bufferViews", json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}))
    }

    pub fn accessor(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        self.push("accessors", json!({"bufferView": view, "componentType": component, "count": count, "type": kind}))
    }

    pub fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let width = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            "MAT4" => 16,
            _ => panic!("{kind}"),
        };
        self.accessor(kind, F32, values.len() / width, bytemuck::cast_slice(values))
    }

    pub fn indices(&mut self, values: &[u32]) -> usize {
        self.accessor("SCALAR", U32, values.len(), bytemuck::cast_slice(values))
    }

    /// A mesh with one primitive; returns its index.
    pub fn mesh(&mut self, primitive: Value) -> usize {
        self.push("meshes", json!({"name": "thing", "primitives": [primitive]}))
    }

    /// One triangle with the corners (0,0,0), (1,0,0), (0,1,0) and a node that shows it.
    pub fn triangle() -> Self {
        Self::triangle_with(json!({}))
    }

    /// Like [`Doc::triangle`], with extra members of the primitive.
    pub fn triangle_with(extra: Value) -> Self {
        let mut doc = Self::new();
        let positions = doc.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        let mut primitive = json!({"attributes": {"POSITION": positions}});
        primitive.as_object_mut().unwrap().extend(extra.as_object().unwrap().clone());
        let mesh = doc.mesh(primitive);
        doc.push("nodes", json!({"mesh": mesh}));
        doc
    }

    /// The primitive of the first mesh.
    pub fn primitive(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]
    }

    /// A PNG image, stored in a buffer view, behind a texture; returns the texture.
    pub fn texture(&mut self, width: u32, height: u32, rgba: &[u8]) -> usize {
        let mut png = std::io::Cursor::new(Vec::new());
        image::write_buffer_with_format(
            &mut png,
            rgba,
            width,
            height,
            image::ColorType::Rgba8,
            image::ImageFormat::Png,
        )
        .unwrap();
        let view = self.view(png.get_ref());
        let source = self.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
        self.push("textures", json!({"source": source}))
    }

    /// The JSON with its buffer entry; `uri` for a `.gltf`.
    pub fn text(&self, uri: Option<String>) -> String {
        let mut json = self.json.clone();
        let mut buffer = json!({"byteLength": self.bin.len()});
        if let Some(uri) = uri {
            buffer["uri"] = uri.into();
        }
        if json.get("buffers").is_none() {
            json["buffers"] = json!([buffer]);
        }
        json.to_string()
    }

    pub fn glb(&self) -> Vec<u8> {
        let mut text = self.text(None).into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut bin = self.bin.clone();
        bin.resize(bin.len().next_multiple_of(4), 0);
        let mut out = b"glTF\x02\0\0\0".to_vec();
        out.extend(((12 + 8 + text.len() + 8 + bin.len()) as u32).to_le_bytes());
        for (kind, chunk) in [(b"JSON", text), (b"BIN\0", bin)] {
            out.extend((chunk.len() as u32).to_le_bytes());
            out.extend(kind);
            out.extend(chunk);
        }
        out
    }
}

/// A folder of its own under the system's, removed at the end.
pub struct Folder(pub PathBuf);

impl Folder {
    pub fn new() -> Self {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("umbrage-scene-{}-{number}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub fn file(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Repeatable random numbers (splitmix64).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e3779b97f4a7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58476d1ce4e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d049bb133111eb);
        z ^ z >> 31
    }

    pub fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit as u64) as usize
    }

    /// 0 to 1.
    pub fn unit(&mut self) -> f32 {
        (self.next() >> 40) as f32 / (1u64 << 24) as f32
    }
}

pub fn base64(bytes: &[u8]) -> String {
    const CODE: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let encode = |chunk: &[u8]| {
        let word = chunk.iter().chain([0, 0].iter()).take(3).fold(0u32, |w, b| w << 8 | u32::from(*b));
        let digit = |i: usize| if i <= chunk.len() { CODE[(word >> (18 - 6 * i)) as usize & 63] as char } else { '=' };
        [digit(0), digit(1), digit(2), digit(3)]
    };
    bytes.chunks(3).flat_map(encode).collect()
}
