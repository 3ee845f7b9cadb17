//! Accessors read with every range checked against its view and every view against its buffer.

use super::file::{File, find};
use ::gltf::json::accessor::{self, Accessor, ComponentType};
use ::gltf::json::{Index, buffer, validation::Checked};

/// Where the elements of an accessor lie.
struct Elements<'a> {
    /// From the first element on; `None` stands for zeros (sparse accessors may have no view).
    bytes: Option<&'a [u8]>,
    stride: usize,
    count: usize,
    kind: ComponentType,
    normalized: bool,
    /// Elements that replace others: index and bytes, ascending.
    overlay: Vec<(usize, &'a [u8])>,
}

impl Elements<'_> {
    fn collect<T: Copy + Default, const N: usize>(&self, read: fn(&[u8]) -> T) -> Vec<[T; N]> {
        let width = self.kind.size();
        let element = |bytes: &[u8]| std::array::from_fn(|c| read(&bytes[c * width..]));
        let mut out = match self.bytes {
            Some(bytes) => (0..self.count).map(|i| element(&bytes[i * self.stride..])).collect(),
            None => vec![[T::default(); N]; self.count],
        };
        for (i, bytes) in &self.overlay {
            out[*i] = element(bytes);
        }
        out
    }
}

impl File {
    /// Number of elements and of components in each; not yet checked against the buffers.
    pub(super) fn shape(&self, index: Index<Accessor>) -> Result<(u64, usize), String> {
        let accessor = find(&self.root.accessors, index.value(), "accessor")?;
        let Checked::Valid(kind) = accessor.type_ else {
            return Err(format!("accessor {index} has an unknown type"));
        };
        Ok((accessor.count.0, kind.multiplicity()))
    }

    /// Elements as floats; integers are converted, normalised ones to 0..1 or -1..1.
    pub(super) fn floats<const N: usize>(&self, index: Index<Accessor>, what: &str) -> Result<Vec<[f32; N]>, String> {
        let elements = self.elements(index, N, what)?;
        Ok(elements.collect(float_reader(elements.kind, elements.normalized)))
    }

    /// Elements as unsigned integers; other component types are an error.
    pub(super) fn integers<const N: usize>(&self, index: Index<Accessor>, what: &str) -> Result<Vec<[u32; N]>, String> {
        let elements = self.elements(index, N, what)?;
        let read: fn(&[u8]) -> u32 = match elements.kind {
            ComponentType::U8 => |b| u32::from(b[0]),
            ComponentType::U16 => |b| u32::from(u16::from_le_bytes([b[0], b[1]])),
            ComponentType::U32 => |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]),
            other => {
                let found = other.as_gl_enum();
                return Err(format!(
                    "accessor {index} ({what}) has component type {found}; allowed are 5121, 5123, 5125"
                ));
            }
        };
        Ok(elements.collect(read))
    }

    fn elements(&self, index: Index<Accessor>, components: usize, what: &str) -> Result<Elements<'_>, String> {
        let (count, found) = self.shape(index)?;
        if found != components {
            return Err(format!("accessor {index} ({what}) has {found} components; {components} are needed"));
        }
        let accessor = &self.root.accessors[index.value()];
        let Checked::Valid(kind) = accessor.component_type else {
            return Err(format!("accessor {index} ({what}) has an unknown component type"));
        };
        let limit = self.buffer_bytes();
        if count > limit {
            return Err(format!("accessor {index} ({what}) has {count} elements but all buffers hold {limit} bytes"));
        }
        let count = count as usize;
        let size = kind.0.size() * components;
        let name = format!("accessor {index} ({what})");
        let offset = accessor.byte_offset.unwrap_or_default().0;
        let (bytes, stride) = match accessor.buffer_view {
            Some(view) => {
                let (bytes, stride) = self.span(view, offset, count, size, &name)?;
                (Some(bytes), stride)
            }
            None if accessor.sparse.is_some() => (None, size),
            None => return Err(format!("{name} has neither a buffer view nor sparse values")),
        };
        let overlay = match &accessor.sparse {
            Some(sparse) => self.overlay(sparse, count, size, &name)?,
            None => Vec::new(),
        };
        Ok(Elements { bytes, stride, count, kind: kind.0, normalized: accessor.normalized, overlay })
    }

    /// The bytes from the first element on, long enough for all of them, and the stride.
    fn span(
        &self,
        view: Index<buffer::View>,
        offset: u64,
        count: usize,
        size: usize,
        name: &str,
    ) -> Result<(&[u8], usize), String> {
        let bytes = self.view(view).map_err(|e| format!("{name}: {e}"))?;
        let stride =
            self.root.buffer_views[view.value()].byte_stride.map_or(size, |s| if s.0 == 0 { size } else { s.0 });
        if stride < size {
            return Err(format!("{name} has elements of {size} bytes but buffer view {view} has a stride of {stride}"));
        }
        let last = (count as u64).saturating_sub(1).checked_mul(stride as u64);
        let end = last.and_then(|l| l.checked_add(offset)?.checked_add(if count == 0 { 0 } else { size as u64 }));
        match end {
            Some(end) if end <= bytes.len() as u64 => Ok((&bytes[offset as usize..], stride)),
            _ => Err(format!(
                "{name} needs {count} elements of {size} bytes (stride {stride}) from {offset} but buffer view {view} holds {} bytes",
                bytes.len()
            )),
        }
    }

    fn overlay(
        &self,
        sparse: &accessor::sparse::Sparse,
        count: usize,
        size: usize,
        name: &str,
    ) -> Result<Vec<(usize, &[u8])>, String> {
        let Checked::Valid(kind) = sparse.indices.component_type else {
            return Err(format!("{name} has sparse indices of an unknown component type"));
        };
        let held = sparse.count.0;
        if held > count as u64 {
            return Err(format!("{name} has {held} sparse values for {count} elements"));
        }
        let held = held as usize;
        let width = kind.0.size();
        let (indices, index_stride) =
            self.span(sparse.indices.buffer_view, sparse.indices.byte_offset.0, held, width, name)?;
        let (values, value_stride) =
            self.span(sparse.values.buffer_view, sparse.values.byte_offset.0, held, size, name)?;
        let mut out = Vec::with_capacity(held);
        for i in 0..held {
            let bytes = &indices[i * index_stride..][..width];
            let target = bytes.iter().rev().fold(0usize, |sum, byte| sum << 8 | usize::from(*byte));
            if target >= count {
                return Err(format!("{name} has the sparse index {target} but {count} elements"));
            }
            out.push((target, &values[i * value_stride..]));
        }
        Ok(out)
    }
}

fn float_reader(kind: ComponentType, normalized: bool) -> fn(&[u8]) -> f32 {
    match (kind, normalized) {
        (ComponentType::F32, _) => |b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
        (ComponentType::U32, _) => |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as f32,
        (ComponentType::U8, false) => |b| f32::from(b[0]),
        (ComponentType::I8, false) => |b| f32::from(b[0] as i8),
        (ComponentType::U16, false) => |b| f32::from(u16::from_le_bytes([b[0], b[1]])),
        (ComponentType::I16, false) => |b| f32::from(i16::from_le_bytes([b[0], b[1]])),
        (ComponentType::U8, true) => |b| f32::from(b[0]) / 255.0,
        (ComponentType::I8, true) => |b| (f32::from(b[0] as i8) / 127.0).max(-1.0),
        (ComponentType::U16, true) => |b| f32::from(u16::from_le_bytes([b[0], b[1]])) / 65535.0,
        (ComponentType::I16, true) => |b| (f32::from(i16::from_le_bytes([b[0], b[1]])) / 32767.0).max(-1.0),
    }
}
