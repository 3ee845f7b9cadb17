//! One glTF primitive as a list of triangles in mesh space.

use super::Attributes;
use super::deform::{Binding, Rest};
use super::file::File;
use ::gltf::json::mesh::{Mode, Primitive, Semantic};
use ::gltf::json::{Accessor, Index, validation::Checked};

/// What a primitive holds before it is posed.
pub(super) struct Geometry {
    pub(super) rest: Rest,
    pub(super) attributes: Vec<Attributes>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Smallest and largest vertex alpha.
    pub(super) alpha: [f32; 2],
    /// Whether the material's texture coordinates are missing.
    pub(super) lacks_uv: bool,
}

/// Whether a primitive has triangles; the error continues a sentence.
pub(super) fn has_triangles(primitive: &Primitive) -> Result<bool, String> {
    match primitive.mode {
        Checked::Valid(mode) => Ok(matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)),
        Checked::Invalid => Err("the mode is unknown; allowed are 0 to 6".to_string()),
    }
}

/// Reads a primitive with triangles; `uv_set` is the set its material's texture uses.
pub(super) fn read(file: &File, primitive: &Primitive, uv_set: Option<u32>) -> Result<Geometry, String> {
    let positions = attribute(primitive, Semantic::Positions).ok_or("the attribute POSITION is missing")?;
    let positions = file.floats::<3>(positions, "POSITION")?;
    let broken = positions.iter().enumerate().find_map(|(i, p)| Some((i, p.iter().find(|v| !v.is_finite())?)));
    if let Some((vertex, value)) = broken {
        return Err(format!("vertex {vertex} has the position value {value}; it must be finite"));
    }
    let count = positions.len();
    let uvs = match uv_set.and_then(|set| attribute(primitive, Semantic::TexCoords(set))) {
        Some(index) => Some(sized(file.floats::<2>(index, "TEXCOORD")?, count, "texture coordinates")?),
        None => None,
    };
    let colors = read_colors(file, primitive, count)?;
    let alphas = colors.iter().map(|c| c >> 24).fold((255, 0), |(low, high), a| (low.min(a), high.max(a)));
    let vertex = |i: usize| Attributes {
        uv: uvs.as_ref().map_or([0.0; 2], |uvs| uvs[i].map(|v| if v.is_finite() { v } else { 0.0 })),
        color: colors.get(i).copied().unwrap_or(u32::MAX),
    };
    Ok(Geometry {
        attributes: (0..count).map(vertex).collect(),
        triangles: read_triangles(file, primitive, count)?,
        rest: Rest {
            targets: read_targets(file, primitive, count)?,
            binding: read_binding(file, primitive, count)?,
            positions,
        },
        alpha: if colors.is_empty() { [1.0; 2] } else { [alphas.0 as f32 / 255.0, alphas.1 as f32 / 255.0] },
        lacks_uv: uv_set.is_some() && uvs.is_none(),
    })
}

fn attribute(primitive: &Primitive, semantic: Semantic) -> Option<Index<Accessor>> {
    primitive.attributes.get(&Checked::Valid(semantic)).copied()
}

fn sized<T>(list: Vec<T>, count: usize, what: &str) -> Result<Vec<T>, String> {
    match list.len() == count {
        true => Ok(list),
        false => Err(format!("there are {} {what} for {count} positions", list.len())),
    }
}

/// COLOR_0 as linear RGBA8; empty where there is none.
fn read_colors(file: &File, primitive: &Primitive, count: usize) -> Result<Vec<u32>, String> {
    let Some(index) = attribute(primitive, Semantic::Colors(0)) else { return Ok(Vec::new()) };
    // a float to integer cast saturates and sends NaN to 0
    let byte = |v: f32| (v * 255.0 + 0.5) as u8;
    let pack = |[r, g, b, a]: [f32; 4]| u32::from_le_bytes([byte(r), byte(g), byte(b), byte(a)]);
    let colors: Vec<u32> = match file.shape(index)?.1 {
        3 => file.floats::<3>(index, "COLOR_0")?.into_iter().map(|[r, g, b]| pack([r, g, b, 1.0])).collect(),
        _ => file.floats::<4>(index, "COLOR_0")?.into_iter().map(pack).collect(),
    };
    sized(colors, count, "vertex colours")
}

fn read_targets(file: &File, primitive: &Primitive, count: usize) -> Result<Vec<Vec<[f32; 3]>>, String> {
    let read = |index| {
        let deltas = sized(file.floats::<3>(index, "morph target POSITION")?, count, "morph deltas")?;
        match deltas.as_flattened().iter().position(|v| !v.is_finite()) {
            Some(i) => Err(format!("vertex {} has the morph delta {}; it must be finite", i / 3, deltas[i / 3][i % 3])),
            None => Ok(deltas),
        }
    };
    primitive.targets.iter().flatten().map(|t| t.positions.map_or(Ok(Vec::new()), read)).collect()
}

fn read_binding(file: &File, primitive: &Primitive, count: usize) -> Result<Option<Binding>, String> {
    let mut binding = Binding { joints: Vec::new(), weights: Vec::new() };
    let sets =
        |set| Some((attribute(primitive, Semantic::Joints(set))?, attribute(primitive, Semantic::Weights(set))?));
    for (joints, weights) in (0..).map_while(sets) {
        binding.joints.push(sized(file.integers::<4>(joints, "JOINTS")?, count, "joint quadruples")?);
        binding.weights.push(sized(file.floats::<4>(weights, "WEIGHTS")?, count, "weight quadruples")?);
    }
    Ok((!binding.joints.is_empty()).then_some(binding))
}

fn read_triangles(file: &File, primitive: &Primitive, count: usize) -> Result<Vec<[u32; 3]>, String> {
    let corners: Vec<u32> = match primitive.indices {
        Some(index) => file.integers::<1>(index, "indices")?.into_flattened(),
        None => (0..count as u32).collect(),
    };
    if let Some(at) = corners.iter().position(|&c| c as usize >= count) {
        return Err(format!("index {at} is {} but there are {count} vertices", corners[at]));
    }
    Ok(match primitive.mode {
        Checked::Valid(Mode::TriangleStrip) => strip(&corners),
        Checked::Valid(Mode::TriangleFan) => fan(&corners),
        _ => corners.as_chunks::<3>().0.to_vec(),
    })
}

/// Every second triangle is turned so that all have the same winding.
fn strip(corners: &[u32]) -> Vec<[u32; 3]> {
    let turn = |(i, w): (usize, &[u32])| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] };
    corners.windows(3).enumerate().map(turn).collect()
}

fn fan(corners: &[u32]) -> Vec<[u32; 3]> {
    let Some((hub, rim)) = corners.split_first() else { return Vec::new() };
    rim.windows(2).map(|w| [w[0], w[1], *hub]).collect()
}
