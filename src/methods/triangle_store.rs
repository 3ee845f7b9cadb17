//! A shadow map that stores triangles (Dai et al. 2008; book, 2.2.4 and 4.6.3): each texel names the triangle nearest to the light
//! at its centre. The lookup tests the light's ray to a sample exactly against the triangles of the texels around it, so depths need
//! no bias beyond rounding, and borders of shadows are those of the triangles.

use super::comparison::{BiasKind, CULL, Comparison, DEPTH_BIAS};
use super::izb::{OWN, own};
use super::map::{self, Map, Screen};
use super::silhouette_edges::welded;
use super::uniform::{self, FIT, RESOLUTION, Uniform};
use super::{DebugPicture, FrameTimes, Method, MethodInfo, MethodSpec, Parameter, Statistics};
use crate::Filter;
use crate::engine::constants::ray_start;
use crate::engine::exact::hit_bindings;
use crate::gpu::structs::{Fit, MapLight};
use crate::gpu::{Binding, Buffer, Compute, spirv};
use crate::lab::{Lab, LabError};
use crate::scene::Scene;
use ash::vk;

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
        default: "walk",
        allowed: "walk, depth or lit",
        meaning: "what decides where no stored triangle lies over a sample: a walk over the mesh from the triangle of its texel, that texel's depth, or nothing",
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

/// What decides where no stored triangle lies over a sample; as in `glsl/methods/triangle_store_lookup.comp`.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Uncovered {
    /// The triangles that follow in the mesh on that of the sample's texel.
    Walk,
    /// The depth of that texel.
    Depth,
    /// Nothing: the sample is lit.
    Lit,
}

struct Settings {
    map: uniform::Settings,
    neighbours: u32,
    uncovered: Uncovered,
    /// Whether the triangle under each pixel is found.
    own: bool,
}

fn settings(spec: &MethodSpec) -> Result<Settings, LabError> {
    let neighbours = spec.u32_in("neighbours", 1, 0..=4)?;
    let mut map = uniform::settings(spec, SIDE)?;
    // the map is that of bias=ids, and its kernel is what is searched
    map.comparison = Comparison { bias: BiasKind::Ids, filter: Filter::Hard, search: neighbours, ..map.comparison };
    let uncovered = match spec.one_of("uncovered", "walk", &["walk", "depth", "lit"])? {
        "depth" => Uncovered::Depth,
        "lit" => Uncovered::Lit,
        _ => Uncovered::Walk,
    };
    Ok(Settings { map, neighbours, uncovered, own: own(spec)? })
}

/// The triangle behind each edge of each triangle, + 1; edge 0 lies across from the first corner. 0 where there is none, or more
/// than one.
fn adjacency(scene: &Scene) -> Vec<u32> {
    let mut behind = vec![0; scene.indices.len()];
    for mesh in scene.meshes.iter().filter(|mesh| mesh.casts) {
        // ends, the lesser first, and which edge of the scene it is
        let mut sides = Vec::with_capacity(mesh.index_count as usize);
        for (triangle, &[a, b, c]) in (mesh.first_index / 3..).zip(welded(scene, mesh).as_chunks().0) {
            sides.extend(
                [[b, c], [c, a], [a, b]].iter().zip(3 * triangle..).map(|([a, b], e)| [*a.min(b), *a.max(b), e]),
            );
        }
        sides.sort_unstable();
        for of_edge in sides.chunk_by(|a, b| a[..2] == b[..2]) {
            if let &[[_, _, one], [_, _, other]] = of_edge {
                behind[one as usize] = other / 3 + 1;
                behind[other as usize] = one / 3 + 1;
            }
        }
    }
    behind
}

pub(super) struct TriangleStore {
    base: Uniform,
    adjacency: Option<Buffer>,
}

impl TriangleStore {
    pub(super) fn new(spec: &MethodSpec, lab: &Lab) -> Result<Self, LabError> {
        let settings = settings(spec)?;
        let screen = if settings.own { Screen::with_owners(lab)? } else { Screen::new(lab)? };
        let mut base = Uniform::new(spec, lab, settings.map, screen)?;
        let adjacency = if settings.uncovered == Uncovered::Walk {
            let words = adjacency(lab.scene());
            let none = vk::BufferUsageFlags::empty();
            lab.upload(&[("adjacent triangles", bytemuck::cast_slice(&words), none, 0)])?.pop()
        } else {
            None
        };
        let keys = [settings.neighbours, settings.uncovered as u32];
        let lookup = |map| lookup(lab, &base.screen, map, adjacency.as_ref(), keys);
        let lookups: Vec<_> = base.maps.iter().map(lookup).collect::<Result<_, _>>()?;
        for (map, lookup) in base.maps.iter_mut().zip(lookups) {
            map.set_lookup(lookup);
        }
        Ok(Self { base, adjacency })
    }
}

/// Visibility of every pixel from the triangles of a map.
fn lookup(
    lab: &Lab,
    screen: &Screen,
    map: &Map,
    adjacency: Option<&Buffer>,
    [neighbours, uncovered]: [u32; 2],
) -> Result<Compute, LabError> {
    let scene = lab.scene_buffers();
    let (own, mut constants) = map.lookup(screen);
    // depths, where they decide, are compared with the receiver's plane
    constants[4] = BiasKind::Plane as u32;
    let masked = map::casters(lab, true).next().is_some();
    let [stride, offset, format] = scene.position_layout.words();
    let more = [1, 0, stride, offset, format, neighbours, uncovered, screen.owners().is_some().into(), masked.into()];
    let indices = Binding::External(scene.indices);
    let fetched = [&hit_bindings(scene)[..], &[indices, adjacency.map_or(indices, Binding::Storage)]].concat();
    let bindings = [&map.samples(screen)[..], &own, &fetched].concat();
    let words = spirv!("methods/triangle_store_lookup.comp");
    let constants = [&constants[..], &more].concat();
    Ok(Compute::new(lab.gpu(), "triangle_store_lookup", words, &bindings, &constants, 0)?)
}

impl Method for TriangleStore {
    fn frame(&mut self, lab: &Lab) -> Result<FrameTimes, LabError> {
        let given = self.base.given(lab)?;
        let mut camera = lab.camera_constants()?;
        camera.rule[3] = ray_start(lab.scene_buffers());
        let (screen, maps) = (&self.base.screen, &self.base.maps);
        lab.frame(|cmd, timer| map::record((lab, &camera), (cmd, timer), screen, maps, &given, |_, _, _| ()))
    }

    of_maps!(self, INFO.name, &self.base.screen, &self.base.maps);

    fn memory(&self) -> Vec<(&'static str, u64)> {
        let mut memory = self.base.memory();
        memory.extend(self.adjacency.as_ref().map(|buffer| ("adjacency", buffer.size)));
        memory
    }

    fn statistics(&mut self, lab: &Lab) -> Result<Statistics, LabError> {
        self.base.statistics(lab)
    }

    fn debug_pictures(&mut self, lab: &Lab) -> Result<Vec<DebugPicture>, LabError> {
        let Some((map, ids)) = self.base.maps.first().and_then(|map| Some((map, map.ids()?))) else {
            return Ok(Vec::new());
        };
        let held = ids.held(lab)?;
        // of different instances, other numbers
        let numbers: Vec<u32> = held.iter().map(|[i, t]| if *t == 0 { u32::MAX } else { t ^ (i << 20) }).collect();
        let side = map.shape().side;
        let picture = crate::output::ids(side, numbers.len() as u32 / side, &numbers)
            .map_err(|error| LabError::Refused(error.to_string()))?;
        Ok(vec![DebugPicture { name: "triangles", width: picture.width, height: picture.height, rgb: picture.rgb }])
    }
}

/// What a frame left of its first light, for tests.
#[doc(hidden)]
pub struct Stored {
    /// Texels along a side of a layer.
    pub side: u32,
    /// The light.
    pub light: MapLight,
    /// Where its layers lie.
    pub fits: Vec<Fit>,
    /// Instance and triangle + 1 of each texel; 0 and 0 where there is none.
    pub triangles: Vec<[u32; 2]>,
    /// Visibility of each pixel.
    pub visibility: Vec<f32>,
}

/// Runs one frame and reads what it left.
///
/// # Errors
/// As [`super::create`].
#[doc(hidden)]
pub fn stored(spec: &MethodSpec, lab: &Lab) -> Result<Stored, LabError> {
    let mut method = TriangleStore::new(spec, lab)?;
    method.frame(lab)?;
    let map = &method.base.maps[0];
    Ok(Stored {
        side: map.shape().side,
        light: bytemuck::pod_read_unaligned(&lab.read_buffer(map.light())?[..size_of::<MapLight>()]),
        fits: bytemuck::pod_collect_to_vec(&lab.read_buffer(map.fits())?),
        triangles: map.ids().map_or(Ok(Vec::new()), |ids| ids.held(lab))?,
        visibility: map.visibility(lab)?,
    })
}
