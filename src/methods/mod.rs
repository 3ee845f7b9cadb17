//! The methods of the literature behind one trait, on the same scene, camera, timers and reference.

/// The part of [`Method`] that is the same for all methods whose maps hold what the last frame saw.
macro_rules! of_maps {
    ($self:ident, $name:expr, $screen:expr, $maps:expr) => {
        fn visibility(&mut $self, lab: &Lab, light: usize) -> Result<Vec<f32>, LabError> {
            $crate::methods::of_light($maps, $name, light)?.visibility(lab)
        }

        fn sampling(&mut $self, lab: &Lab, light: usize) -> Result<Option<$crate::methods::Sampling>, LabError> {
            let map = $crate::methods::of_light($maps, $name, light)?;
            $crate::methods::map_sampling::sampling(lab, $screen, map).map(Some)
        }

        fn masks(&$self) -> Option<$crate::methods::Masks<'_>> {
            Some($crate::methods::map::masks($maps))
        }
    };
}

mod asm;
mod asm_gpu;
mod bent;
mod changes;
mod comparison;
mod csm;
mod forward;
mod frustum_faces;
pub(crate) mod fvsm;
mod hybrid;
mod izb;
mod izb_owner;
mod lispsm;
mod logpsm;
mod map;
mod map_cover;
mod map_fit;
mod map_light;
mod map_sampling;
mod plane;
mod plane_optimal;
mod polygon_ids;
mod psm;
pub(crate) mod quadtree;
pub(crate) mod qvsm;
mod raytraced;
mod rmsm;
mod rmsm_pages;
mod rmsm_pictures;
mod rmsm_sampling;
pub(crate) mod rtw;
mod rtw_pictures;
mod sampling;
mod silhouette;
mod silhouette_edges;
mod silhouette_map;
mod spec;
mod temporal;
pub(crate) mod tiled;
mod tiles;
pub(crate) mod tree;
mod triangle_store;
mod tsm;
mod uniform;
mod warp;
mod warp_passes;

pub use crate::gpu::structs::SamplingError;
#[doc(hidden)]
pub use forward::ForwardStage;
#[doc(hidden)]
pub use izb::{Lists as IzbLists, lists as izb_lists};
pub use sampling::Sampling;
#[doc(hidden)]
pub use sampling::SamplingInputs;
#[doc(hidden)]
pub use silhouette::SilhouetteStage;
#[doc(hidden)]
pub use silhouette_edges::Outline;
pub use spec::MethodSpec;
#[doc(hidden)]
pub use triangle_store::{Stored as StoredTriangles, stored as stored_triangles};

use crate::Light;
use crate::gpu::{Buffer, Image};
use crate::lab::{Lab, LabError};

/// One key of a method.
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// The key as typed before `=`.
    pub key: &'static str,
    /// The value used when the key is not given.
    pub default: &'static str,
    /// What is allowed, in one phrase.
    pub allowed: &'static str,
    /// What it does, with its unit.
    pub meaning: &'static str,
}

/// A method for a lab, or why there is none.
type Created = Result<Box<dyn Method>, LabError>;

/// What a method is and which keys it takes.
#[derive(Debug, Clone, Copy)]
pub struct MethodInfo {
    /// Name as typed.
    pub name: &'static str,
    /// Where it comes from: paper and section.
    pub source: &'static str,
    /// One sentence.
    pub summary: &'static str,
    /// Its keys.
    pub parameters: &'static [Parameter],
    /// Checks keys and values.
    check: fn(&MethodSpec) -> Result<(), LabError>,
    /// Makes it for keys and values that were checked.
    create: fn(&MethodSpec, &Lab) -> Created,
}

/// Times of one frame in milliseconds.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FrameTimes {
    /// GPU time of the depth prepass (shared by all methods, not part of `ms`).
    pub prepass_ms: f64,
    /// From after the depth prepass to the end of the lookup.
    pub ms: f64,
    /// Wall time of submit and fence of the same work; a check on `ms`.
    pub wall_ms: f64,
    /// Stages in order; they add up to `ms` but for rounding.
    pub stages: Vec<(&'static str, f64)>,
}

/// Pages of one level.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct LevelStatistics {
    /// Level; 0 is the finest.
    pub level: u32,
    /// Distinct pages the samples asked for at the finest level bias.
    pub requested: u32,
    /// Pages drawn and resident.
    pub resident: u32,
    /// Requested pages served by a page coarser than one texel a pixel (level bias 0) or, with a positive bias, coarser than asked.
    pub refused: u32,
}

/// What the last frame did.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Statistics {
    /// Side of the conventional map that would have the finest resident texel over the same extent.
    pub effective_resolution: f64,
    /// Per level, finest first; empty for methods without pages.
    pub levels: Vec<LevelStatistics>,
    /// Named counters, such as `pairs` or `triangles`.
    pub counters: Vec<(&'static str, u64)>,
}

/// A false-colour picture of an inner state: name, width, height, RGB8.
#[derive(Debug, Clone)]
pub struct DebugPicture {
    /// File stem.
    pub name: &'static str,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Three bytes a pixel, row 0 at the top.
    pub rgb: Vec<u8>,
}

/// Where the visibility of a method's last frame lies on the device.
#[cfg_attr(not(feature = "window"), allow(dead_code))] // the window shows it
pub struct Masks<'a> {
    /// Images of a 32-bit word a pixel, in `TRANSFER_SRC_OPTIMAL`; all their layers in order hold the lights.
    pub(crate) images: Vec<&'a Image>,
    /// Bits of a light, from the lowest of the first layer; 32: a float.
    pub(crate) bits: u32,
}

/// What debug views show of pages; words as in `glsl/shared/page_word.glsl`.
#[cfg_attr(not(feature = "window"), allow(dead_code))] // the window shows it
pub struct PageViews<'a> {
    /// A page word for each pixel.
    pub(crate) pages: &'a Buffer,
    /// The state of each layer of the atlas.
    pub(crate) states: &'a Buffer,
    /// [`crate::gpu::structs::Slot`] structs.
    pub(crate) layers: &'a Buffer,
    /// Readable by compute shaders.
    pub(crate) atlas: &'a Image,
}

/// A way to compute visibility for every pixel of a [`Lab`]'s view.
pub trait Method {
    /// Runs one complete frame, prepass included, and waits for it.
    fn frame(&mut self, lab: &Lab) -> Result<FrameTimes, LabError>;
    /// Visibility of the last frame for a light of the view by its index: one value a pixel, 1 lit, 0 shadowed, 1 where
    /// there is no surface, 0 where n.l <= 0 or the light does not reach.
    ///
    /// # Errors
    /// [`LabError::Usage`] for an index that the view does not have, [`LabError::Refused`] for a light that the method does
    /// not serve, [`LabError::Engine`] for everything Vulkan reports.
    fn visibility(&mut self, lab: &Lab, light: usize) -> Result<Vec<f32>, LabError>;
    /// Device memory by purpose, in bytes.
    fn memory(&self) -> Vec<(&'static str, u64)>;
    /// Counters of the last frame.
    fn statistics(&mut self, lab: &Lab) -> Result<Statistics, LabError>;
    /// Pictures of the inner state after the last frame; empty for methods without any.
    fn debug_pictures(&mut self, _lab: &Lab) -> Result<Vec<DebugPicture>, LabError> {
        Ok(Vec::new())
    }
    /// How large the texels of a light's map looked in the last frame's image; `None` for methods that cannot tell.
    ///
    /// # Errors
    /// As [`Method::visibility`].
    fn sampling(&mut self, _lab: &Lab, _light: usize) -> Result<Option<Sampling>, LabError> {
        Ok(None)
    }
    /// The last frame's visibility on the device; `None` where it is computed on the CPU.
    fn masks(&self) -> Option<Masks<'_>> {
        None
    }
    /// Readies [`Method::page_views`] for the last frame; `false` for methods without pages.
    ///
    /// # Errors
    /// [`LabError::Engine`] for everything Vulkan reports.
    fn update_pages(&mut self, _lab: &Lab) -> Result<bool, LabError> {
        Ok(false)
    }
    /// What [`Method::update_pages`] made last; `None` before the first.
    fn page_views(&self) -> Option<PageViews<'_>> {
        None
    }
    /// As [`Method::frame`], but with the pages that the last one left, seen by the view's camera: nothing is asked for,
    /// chosen or drawn. Lights and scene must be those of the last frame. `None` for methods without pages.
    ///
    /// # Errors
    /// As [`Method::frame`]; [`LabError::Engine`] before the first.
    fn frozen_frame(&mut self, _lab: &Lab) -> Result<Option<FrameTimes>, LabError> {
        Ok(None)
    }
}

/// All methods; the first is the default.
pub static METHODS: &[MethodInfo] = &[
    rmsm::INFO,
    uniform::INFO,
    csm::INFO,
    lispsm::INFO,
    tsm::INFO,
    psm::INFO,
    logpsm::INFO,
    plane_optimal::INFO,
    rtw::INFO,
    asm::INFO,
    asm_gpu::INFO,
    fvsm::INFO,
    qvsm::INFO,
    tiled::INFO,
    izb::INFO,
    silhouette::INFO,
    triangle_store::INFO,
    forward::INFO,
    hybrid::INFO,
    temporal::INFO,
    raytraced::INFO,
];

fn info(spec: &MethodSpec) -> Result<&'static MethodInfo, LabError> {
    METHODS.iter().find(|method| method.name == spec.name).ok_or_else(|| {
        let names: Vec<_> = METHODS.iter().map(|method| method.name).collect();
        LabError::Usage(format!("method '{}' does not exist, allowed is {}", spec.name, names.join(", ")))
    })
}

/// Checks name, keys and values without a device.
///
/// # Errors
/// [`LabError::Usage`] with the name, key or value and what is allowed.
pub fn check(spec: &MethodSpec) -> Result<(), LabError> {
    let info = info(spec)?;
    spec.known(info.parameters)?;
    (info.check)(spec)
}

/// Makes a method for a lab.
///
/// # Errors
/// As [`check`]; [`LabError::Refused`] for a light the method cannot serve; [`LabError::Engine`] as the device reports.
pub fn create(spec: &MethodSpec, lab: &Lab) -> Created {
    check(spec)?;
    hard_lights(spec, lab)?;
    (info(spec)?.create)(spec, lab)
}

/// Hard-shadow methods serve lights without extent.
fn hard_lights(spec: &MethodSpec, lab: &Lab) -> Result<(), LabError> {
    match lab.view().lights.iter().position(Light::has_extent) {
        Some(index) => Err(LabError::Refused(format!(
            "method '{}' makes hard shadows and light {index} has an extent; allowed are directional lights with angular_diameter_deg 0, spot and point lights",
            spec.name
        ))),
        None => Ok(()),
    }
}

/// For methods that serve one light, a directional one.
fn one_directional(spec: &MethodSpec, lab: &Lab) -> Result<(), LabError> {
    match &lab.view().lights[..] {
        [Light::Directional { .. }] => Ok(()),
        [_] => Err(LabError::Refused(format!("method '{}' serves directional lights only", spec.name))),
        lights => {
            Err(LabError::Refused(format!("method '{}' serves one light and the view has {}", spec.name, lights.len())))
        }
    }
}

/// For methods whose fragment shaders write to buffers.
fn fragment_stores(spec: &MethodSpec, lab: &Lab) -> Result<(), LabError> {
    if lab.has_fragment_stores() {
        return Ok(());
    }
    Err(LabError::Refused(format!(
        "'{spec}' needs the feature fragmentStoresAndAtomics, which device '{}' does not have",
        lab.device_name()
    )))
}

/// What a method keeps for a light.
fn of_light<'a, T>(each: &'a [T], method: &str, light: usize) -> Result<&'a T, LabError> {
    each.get(light).ok_or_else(|| {
        LabError::Refused(format!("method '{method}' serves {} lights and light {light} was asked for", each.len()))
    })
}
