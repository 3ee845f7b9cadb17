//! Shadow silhouette maps (Sen, Cammarano, Hanrahan 2003; book, 4.6.2): beside a conventional map a second one, half a texel
//! off, whose texels hold a point of a silhouette edge as the light sees it. The lookup joins the points of neighbouring texels
//! and takes the depth test from the side of that line on which the sample lies: borders of shadows are lines, not staircases.

use super::comparison::Comparison;
use super::map::Screen;
use super::silhouette_edges::Outline;
use super::uniform::{self, Uniform};
use super::{Method, MethodInfo, MethodSpec, Parameter};
use crate::gpu::structs::{Fit, MapLight};
use crate::lab::{Lab, LabError};

const SIDE: u32 = 1024;

const PARAMETERS: [Parameter; 5] = Comparison::hard_keys(&[
    Parameter {
        default: "1024",
        meaning: "side of both maps in texels; a cube's maps share the same number of texels",
        ..uniform::RESOLUTION
    },
    uniform::FIT,
]);

pub(super) const INFO: MethodInfo = MethodInfo {
    name: "silhouette",
    source: "Sen, Cammarano, Hanrahan 2003; Eisemann et al. 2011, 4.6.2",
    summary: "A fitted map beside one that holds points of the casters' silhouettes, which are found on the GPU in every frame",
    parameters: &PARAMETERS,
    check: |spec| uniform::settings(spec, SIDE).map(|_| ()),
    create: |spec, lab| Ok(Box::new(make(spec, lab)?)),
};

fn make(spec: &MethodSpec, lab: &Lab) -> Result<Uniform, LabError> {
    let settings = uniform::settings(spec, SIDE)?;
    let screen = Screen::with_edges(lab, &settings.comparison)?;
    Uniform::new(spec, lab, settings, screen)
}

/// The method with what it found for the view's first light, for tests.
#[doc(hidden)]
pub struct SilhouetteStage(Uniform);

impl SilhouetteStage {
    /// As [`super::create`], without its checks.
    ///
    /// # Errors
    /// As [`super::create`].
    pub fn new(spec: &MethodSpec, lab: &Lab) -> Result<Self, LabError> {
        make(spec, lab).map(Self)
    }

    /// The method itself.
    pub fn method(&mut self) -> &mut dyn Method {
        &mut self.0
    }

    /// Edges that the last frame saw as silhouettes.
    ///
    /// # Errors
    /// [`LabError::Engine`] for everything Vulkan reports.
    pub fn silhouettes(&self, lab: &Lab) -> Result<Vec<Outline>, LabError> {
        let (screen, map) = self.0.first();
        match (screen.edges(), map.silhouettes()) {
            (Some(edges), Some(silhouettes)) => edges.outlines(lab, &silhouettes.found(lab)?),
            _ => Ok(Vec::new()),
        }
    }

    /// What each texel of the last frame's silhouette map holds, all layers: coordinates in the texel.
    ///
    /// # Errors
    /// As [`Self::silhouettes`].
    pub fn points(&self, lab: &Lab) -> Result<Vec<Option<[f32; 2]>>, LabError> {
        self.0.first().1.silhouettes().map_or(Ok(Vec::new()), |silhouettes| silhouettes.held(lab))
    }

    /// The light and where the layers of its map lie.
    ///
    /// # Errors
    /// As [`Self::silhouettes`].
    pub fn place(&self, lab: &Lab) -> Result<(MapLight, Vec<Fit>), LabError> {
        let map = self.0.first().1;
        let light = bytemuck::pod_read_unaligned(&lab.read_buffer(map.light())?[..size_of::<MapLight>()]);
        Ok((light, bytemuck::pod_collect_to_vec(&lab.read_buffer(map.fits())?)))
    }
}
