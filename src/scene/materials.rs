//! Base colour and alpha of glTF materials, and which meshes need an alpha test.

use super::file::{File, find, label};
use super::images::{Images, source};
use super::{Blend, Material};
use ::gltf::json::material::{AlphaMode, Material as Json};
use ::gltf::json::texture::{Info, WrappingMode};
use ::gltf::json::validation::Checked;
use std::collections::{BTreeMap, BTreeSet};

/// Cutoff at which BLEND materials are tested.
const BLEND_CUTOFF: f32 = 0.5;

/// How a mesh with a material is treated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Visibility {
    /// Every point is cut away.
    Nothing,
    /// No point is cut away.
    All,
    /// Alpha decides.
    Tested,
}

/// What loading a mesh needs to know of its material.
pub(super) struct Surface {
    /// Texture coordinate set of the base colour, where there is a texture.
    pub(super) uv_set: Option<u32>,
    mode: AlphaMode,
    image: Option<usize>,
}

/// The materials of a scene; `None` is the default material of glTF.
pub(super) struct Materials {
    numbers: BTreeMap<Option<usize>, usize>,
    surfaces: Vec<Surface>,
    stored: Vec<Material>,
    images: Images,
}

impl Materials {
    /// Reads the materials named and decodes their images.
    pub(super) fn read(
        file: &File,
        used: &BTreeSet<Option<usize>>,
        blend: Blend,
        warnings: &mut Vec<String>,
    ) -> Result<Self, String> {
        let mut wanted: BTreeMap<usize, bool> = BTreeMap::new();
        let (mut numbers, mut surfaces, mut stored) = (BTreeMap::new(), Vec::new(), Vec::new());
        let default = Json::default();
        for &index in used {
            let json = index.map_or(Ok(&default), |i| find(&file.root.materials, i, "material"))?;
            let name =
                index.map_or_else(|| "the default material".into(), |i| label("material", i, json.name.as_ref()));
            let (surface, material) = read(file, json, blend).map_err(|e| format!("{name}: {e}"))?;
            if surface.uv_set.is_some() && surface.image.is_none() {
                warnings.push(format!("{name}: its texture names no PNG or JPEG image and was left out"));
            }
            if let Some(image) = surface.image {
                *wanted.entry(image).or_default() |= surface.mode != AlphaMode::Opaque;
            }
            numbers.insert(index, surfaces.len());
            surfaces.push(surface);
            stored.push(material);
        }
        Ok(Self { numbers, surfaces, stored, images: Images::decode(file, &wanted)? })
    }

    /// Number and surface of a material that was named to [`Materials::read`].
    pub(super) fn get(&self, index: Option<usize>) -> Option<(u32, &Surface)> {
        let number = *self.numbers.get(&index)?;
        Some((number as u32, &self.surfaces[number]))
    }

    /// Whether alpha cuts a mesh whose vertex alpha lies in `vertex`; bounds over the whole texture, so `Tested`
    /// may turn out to cut nothing.
    pub(super) fn visibility(&self, material: u32, vertex: [f32; 2]) -> Visibility {
        let surface = &self.surfaces[material as usize];
        let stored = &self.stored[material as usize];
        if surface.mode == AlphaMode::Opaque {
            return Visibility::All;
        }
        let texture = surface.image.and_then(|i| self.images.0.get(&i)).map_or([1.0, 1.0], |i| i.alpha);
        let alpha = |end: usize| stored.base_color[3] * texture[end] * vertex[end];
        if stored.translucent == 1 {
            return match (alpha(0), alpha(1)) {
                (_, most) if most <= 0.0 => Visibility::Nothing,
                (least, _) if least >= 1.0 => Visibility::All,
                _ => Visibility::Tested,
            };
        }
        match stored.alpha_cutoff {
            cutoff if alpha(1) < cutoff => Visibility::Nothing,
            cutoff if alpha(0) >= cutoff => Visibility::All,
            _ => Visibility::Tested,
        }
    }

    /// Materials and texels as the scene stores them.
    pub(super) fn finish(mut self) -> Result<(Vec<Material>, Vec<u32>), String> {
        let texels = self.images.pack()?;
        for (surface, material) in self.surfaces.iter().zip(&mut self.stored) {
            if let Some(image) = surface.image.and_then(|i| self.images.0.get(&i)) {
                (material.texel_offset, material.width, material.height) = (image.offset, image.width, image.height);
            }
        }
        Ok((self.stored, texels))
    }
}

impl Surface {
    /// Whether the material casts shadows.
    pub(super) fn casts(&self, blend: Blend) -> bool {
        self.mode != AlphaMode::Blend || blend != Blend::Ignored
    }
}

/// A material without texture, white unless told.
pub(super) fn plain(base_color: [f32; 4]) -> Material {
    Material { base_color, ..Material::default() }
}

fn read(file: &File, json: &Json, blend: Blend) -> Result<(Surface, Material), String> {
    let Checked::Valid(mode) = json.alpha_mode else {
        return Err("alphaMode is unknown; allowed are OPAQUE, MASK and BLEND".to_string());
    };
    let base = json.pbr_metallic_roughness.base_color_factor.0;
    if let Some(value) = base.iter().find(|v| !v.is_finite()) {
        return Err(format!("baseColorFactor holds {value}; it must be finite"));
    }
    let cutoff = match mode {
        AlphaMode::Opaque => 0.0,
        AlphaMode::Mask => json.alpha_cutoff.unwrap_or_default().0,
        AlphaMode::Blend => BLEND_CUTOFF,
    };
    if !(0.0..=f32::MAX).contains(&cutoff) {
        return Err(format!("alphaCutoff is {cutoff}; it must be finite and not negative"));
    }
    let translucent = u32::from(mode == AlphaMode::Blend && blend == Blend::Translucent);
    let mut material = Material { alpha_cutoff: cutoff, translucent, ..plain(base) };
    let mut surface = Surface { uv_set: None, mode, image: None };
    if let Some(info) = &json.pbr_metallic_roughness.base_color_texture {
        surface.uv_set = Some(uv_set(info));
        surface.image = source(file, info.index)?;
        [material.uv_row0, material.uv_row1] = uv_rows(info)?;
        material.wrap = wrap(file, info)?;
    }
    Ok((surface, material))
}

fn uv_set(info: &Info) -> u32 {
    let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref());
    transform.and_then(|t| t.tex_coord).unwrap_or(info.tex_coord)
}

/// Rows of translation * rotation * scale of `KHR_texture_transform`. A positive angle turns counter-clockwise as
/// seen with v pointing down, hence the signs.
fn uv_rows(info: &Info) -> Result<[[f32; 4]; 2], String> {
    let Some(t) = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref()) else {
        return Ok([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]]);
    };
    let (sin, cos) = t.rotation.0.sin_cos();
    let ([u, v], [x, y]) = (t.scale.0, t.offset.0);
    let rows = [[cos * u, sin * v, x, 0.0], [-sin * u, cos * v, y, 0.0]];
    match rows.as_flattened().iter().all(|v| v.is_finite()) {
        true => Ok(rows),
        false => Err("KHR_texture_transform is not finite".to_string()),
    }
}

fn wrap(file: &File, info: &Info) -> Result<u32, String> {
    let texture = find(&file.root.textures, info.index.value(), "texture")?;
    let Some(index) = texture.sampler else { return Ok(0) };
    let sampler = find(&file.root.samplers, index.value(), "sampler")?;
    let code = |mode: Checked<WrappingMode>| match mode {
        Checked::Valid(WrappingMode::Repeat) => Ok(0),
        Checked::Valid(WrappingMode::MirroredRepeat) => Ok(1),
        Checked::Valid(WrappingMode::ClampToEdge) => Ok(2),
        Checked::Invalid => Err(format!("sampler {index} has an unknown wrap mode")),
    };
    Ok(code(sampler.wrap_s)? | code(sampler.wrap_t)? << 2)
}
