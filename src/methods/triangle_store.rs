//! A shadow map that stores triangles (Dai et al. 2008; book, 2.2.4 and 4.6.3): each texel names the triangle nearest to the light
//! at its centre. The lookup tests the light's ray to a sample exactly against the triangles of the texels around it, so depths need
//! no bias beyond rounding, and borders of shadows are those of the triangles.

use super::comparison::{BiasKind, CULL, Comparison, DEPTH_BIAS};
use super::izb::{OWN, own};
use super::map::{self, Map, Screen};
use super::uniform::{self, FIT, RESOLUTION, Uniform};
use super::{DebugPicture, FrameTimes, Method, MethodInfo, MethodSpec, Parameter, Statistics};
use crate::Filter;
use crate::engine::constants::ray_start;
use crate::engine::exact::hit_bindings;
use crate::gpu::{Binding, Compute, spirv};
use crate::lab::{Lab, LabError};

const SIDE: u32 = 1024;

const PARAMETERS: &[Parameter] = &[
    Parameter { default: "1024", ..RESOLUTION },
    FIT,
    Parameter {
        key: "neighbours",
        default: "1",
        allowed: "0 to 4",
        meaning: "texels around a sample's own, either way, whose triangles are tested too",
    },
    Parameter {
        key: "uncovered",
        default: "lit",
        allowed: "lit, depth",
        meaning: "what a sample is over which no stored triangle lies: lit, or what the depth of its texel says with the receiver plane's bias",
    },
    OWN,
    DEPTH_BIAS,
    CULL,
];

pub(super) const INFO: MethodInfo = MethodInfo {
    name: "triangle_store",
    source: "Dai et al. 2008; Eisemann et al. 2011, 2.2.4 and 4.6.3",
    summary: "A fitted map that holds the nearest triangle of each texel; rays are tested against those of the texels around a sample",
    parameters: PARAMETERS,
    check: |spec| settings(spec).map(|_| ()),
    create: |spec, lab| Ok(Box::new(TriangleStore::new(spec, lab)?)),
};

struct Settings {
    map: uniform::Settings,
    neighbours: u32,
    uncovered: u32,
    /// Whether the triangle under each pixel is found.
    own: bool,
}

fn settings(spec: &MethodSpec) -> Result<Settings, LabError> {
    let neighbours = spec.u32_in("neighbours", 1, 0..=4)?;
    let mut map = uniform::settings(spec, SIDE)?;
    // the map is that of bias=ids, and its kernel is what is searched
    map.comparison =
        Comparison { bias: BiasKind::Ids, filter: Filter::Hard, search: neighbours, ..map.comparison };
    let kinds = ["lit", "depth", "small", "agree", "both"];
    let kind = spec.one_of("uncovered", "lit", &kinds)?;
    let uncovered = kinds.iter().position(|k| *k == kind).unwrap_or(0) as u32;
    Ok(Settings { map, neighbours, uncovered, own: own(spec)? })
}

pub(super) struct TriangleStore(Uniform);

impl TriangleStore {
    pub(super) fn new(spec: &MethodSpec, lab: &Lab) -> Result<Self, LabError> {
        let Settings { map, neighbours, uncovered, own } = settings(spec)?;
        let screen = if own { Screen::with_owners(lab)? } else { Screen::new(lab)? };
        let mut base = Uniform::new(spec, lab, map, screen)?;
        let lookups: Vec<_> = base.maps.iter().map(|map| lookup(lab, &base.screen, map, [neighbours, uncovered])).collect::<Result<_, _>>()?;
        for (map, lookup) in base.maps.iter_mut().zip(lookups) {
            map.set_lookup(lookup);
        }
        Ok(Self(base))
    }
}

/// Visibility of every pixel from the triangles of a map.
fn lookup(lab: &Lab, screen: &Screen, map: &Map, [neighbours, uncovered]: [u32; 2]) -> Result<Compute, LabError> {
    let scene = lab.scene_buffers();
    let (own, mut constants) = map.lookup(screen);
    // depths, where they decide, are compared with the receiver's plane
    constants[4] = BiasKind::Plane as u32;
    let masked = map::casters(lab, true).next().is_some();
    let [stride, offset, format] = scene.position_layout.words();
    let constants = [
        &constants[..],
        &[1, 0, stride, offset, format, neighbours, uncovered, screen.owners().is_some().into(), masked.into()],
    ]
    .concat();
    let fetched = [&hit_bindings(scene)[..], &[Binding::External(scene.indices)]].concat();
    let bindings = [&map.samples(screen)[..], &own, &fetched].concat();
    let words = spirv!("methods/triangle_store_lookup.comp");
    Ok(Compute::new(lab.gpu(), "triangle_store_lookup", words, &bindings, &constants, 0)?)
}

impl Method for TriangleStore {
    fn frame(&mut self, lab: &Lab) -> Result<FrameTimes, LabError> {
        let given = self.0.given(lab)?;
        let mut camera = lab.camera_constants()?;
        camera.rule[3] = ray_start(lab.scene_buffers());
        let (screen, maps) = (&self.0.screen, &self.0.maps);
        lab.frame(|cmd, timer| map::record((lab, &camera), (cmd, timer), screen, maps, &given, |_, _, _| ()))
    }

    of_maps!(self, INFO.name, &self.0.screen, &self.0.maps);

    fn memory(&self) -> Vec<(&'static str, u64)> {
        self.0.memory()
    }

    fn statistics(&mut self, lab: &Lab) -> Result<Statistics, LabError> {
        self.0.statistics(lab)
    }

    fn debug_pictures(&mut self, lab: &Lab) -> Result<Vec<DebugPicture>, LabError> {
        self.0.debug_pictures(lab)
    }
}
