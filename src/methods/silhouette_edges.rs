//! The edges of a scene's casters with the triangles that share them, found once, and the buffers in which every frame lists
//! those that a light sees as silhouettes.

use crate::gpu::structs::{Edge, EdgeRun};
use crate::gpu::{Binding, Buffer, Compute, Gpu, spirv};
use crate::host::SceneBuffers;
use crate::lab::{Lab, LabError};
use crate::scene::{Mesh, Scene};
use ash::vk;
use std::collections::HashMap;
use std::sync::Arc;

/// Edges of a run; as in `glsl/methods/silhouette.glsl`.
const RUN_EDGES: u32 = 256;
/// Workgroups that every device dispatches along an axis. Numbers of edges then have 24 bits at most, which leaves 5 of those of
/// a depth for what is nearest.
const MOST_RUNS: u32 = 65_535;

/// What is known of edges without a light.
#[derive(Default)]
struct Topology {
    runs: Vec<EdgeRun>,
    edges: Vec<Edge>,
    opposites: Vec<u32>,
}

impl Topology {
    /// Of all that cast and are not alpha tested: those have no silhouettes in their geometry. Vertices at one place of a mesh
    /// are one.
    fn of(scene: &Scene) -> Self {
        let mut topology = Self::default();
        for mesh in scene.meshes.iter().filter(|mesh| mesh.casts && !mesh.alpha_tested) {
            let first = topology.edges.len() as u32;
            topology.add(scene, mesh);
            let end = topology.edges.len() as u32;
            for instance in mesh.first_instance..mesh.first_instance + mesh.instance_count {
                topology.runs.extend((first..end).step_by(RUN_EDGES as usize).map(|first| EdgeRun {
                    instance,
                    first,
                    count: RUN_EDGES.min(end - first),
                }));
            }
        }
        topology
    }

    fn add(&mut self, scene: &Scene, mesh: &Mesh) {
        let welded = welded(scene, mesh);
        // ends, the lesser first, and the third corner
        let mut sides: Vec<[u32; 3]> = Vec::with_capacity(welded.len());
        for &[a, b, c] in welded.as_chunks().0 {
            if a != b && b != c && c != a {
                sides.extend([[a, b, c], [b, c, a], [c, a, b]].map(|[a, b, c]| [a.min(b), a.max(b), c]));
            }
        }
        sides.sort_unstable();
        sides.dedup();
        for of_edge in sides.chunk_by(|a, b| a[..2] == b[..2]) {
            let (first, count) = (self.opposites.len() as u32, of_edge.len() as u32);
            self.edges.push(Edge { ends: [of_edge[0][0], of_edge[0][1]], first, count });
            self.opposites.extend(of_edge.iter().map(|side| side[2]));
        }
    }
}

/// The indices of a mesh, with one vertex for all in one place.
pub(super) fn welded(scene: &Scene, mesh: &Mesh) -> Vec<u32> {
    let mut places = HashMap::new();
    let indices = &scene.indices[mesh.first_index as usize..(mesh.first_index + mesh.index_count) as usize];
    // + 0.0 makes one of both zeros
    let place = |vertex: u32| scene.positions[vertex as usize].map(|v| (v + 0.0).to_bits());
    indices.iter().map(|&vertex| *places.entry(place(vertex)).or_insert(vertex)).collect()
}

/// An edge of an instance.
#[doc(hidden)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Outline {
    /// Entry in [`Scene::instances`].
    pub instance: u32,
    /// Entries in [`Scene::positions`]; of vertices in one place any.
    pub ends: [u32; 2],
}

/// The edges on the device.
pub(super) struct Edges {
    /// Runs, edges, opposites.
    buffers: Vec<Buffer>,
    run_count: u32,
    scene: SceneBuffers,
}

impl Edges {
    pub(super) fn new(lab: &Lab) -> Result<Self, LabError> {
        let topology = Topology::of(lab.scene());
        let run_count = topology.runs.len() as u32;
        if run_count > MOST_RUNS {
            return Err(LabError::Refused(format!(
                "the casters' edges make {run_count} runs of at most {RUN_EDGES} of one instance, silhouettes are found among {MOST_RUNS}",
            )));
        }
        let none = vk::BufferUsageFlags::empty();
        let buffers = lab.upload(&[
            ("edge runs", bytemuck::cast_slice(&topology.runs), none, 0),
            ("edges", bytemuck::cast_slice(&topology.edges), none, 0),
            ("edge opposites", bytemuck::cast_slice(&topology.opposites), none, 0),
        ])?;
        Ok(Self { buffers, run_count, scene: *lab.scene_buffers() })
    }

    /// Bits of the greatest number of an edge.
    pub(super) fn number_bits(&self) -> u32 {
        (self.run_count * RUN_EDGES).max(1).ilog2() + 1
    }

    pub(super) fn outlines(&self, lab: &Lab, numbers: &[u32]) -> Result<Vec<Outline>, LabError> {
        let runs: Vec<EdgeRun> = read(lab, &self.buffers[0])?;
        let edges: Vec<Edge> = read(lab, &self.buffers[1])?;
        let outline = |&number: &u32| {
            let run = runs[(number / RUN_EDGES) as usize];
            Outline { instance: run.instance, ends: edges[(run.first + number % RUN_EDGES) as usize].ends }
        };
        Ok(numbers.iter().map(outline).collect())
    }

    pub(super) fn bytes(&self) -> u64 {
        self.buffers.iter().map(|b| b.size).sum()
    }

    /// What `glsl/methods/silhouette.glsl` declares.
    pub(super) fn bindings<'a>(&'a self, list: &'a Buffer) -> Vec<Binding<'a>> {
        let scene = [Binding::External(self.scene.positions), Binding::External(self.scene.instances)];
        self.buffers.iter().map(Binding::Storage).chain(scene).chain([Binding::Storage(list)]).collect()
    }

    /// Room for a draw and the numbers of all edges.
    pub(super) fn list(&self, gpu: &Arc<Gpu>) -> Result<Buffer, LabError> {
        let room = 4 * u64::from(self.run_count * RUN_EDGES);
        let size = size_of::<vk::DrawIndirectCommand>() as u64 + room;
        Ok(Buffer::storage(gpu, "silhouettes", size, vk::BufferUsageFlags::INDIRECT_BUFFER)?)
    }

    /// Constants 3 to 5 of the shaders.
    pub(super) fn position_words(&self) -> [u32; 3] {
        self.scene.position_layout.words()
    }

    /// The pass that lists silhouettes; `position`: whether the light has one.
    pub(super) fn select(
        &self,
        gpu: &Arc<Gpu>,
        light: &Buffer,
        list: &Buffer,
        position: u32,
    ) -> Result<Compute, LabError> {
        let bindings = [&[Binding::Uniform(light)][..], &self.bindings(list)].concat();
        let [stride, offset, format] = self.position_words();
        let constants = [0, position, 0, stride, offset, format];
        Ok(Compute::new(gpu, "silhouette_select", spirv!("methods/silhouette_select.comp"), &bindings, &constants, 0)?)
    }

    /// Workgroups of that pass.
    pub(super) fn groups(&self) -> [u32; 3] {
        [self.run_count, 1, 1]
    }
}

/// All whole structs that a buffer holds.
fn read<T: bytemuck::Pod>(lab: &Lab, buffer: &Buffer) -> Result<Vec<T>, LabError> {
    let bytes = lab.read_buffer(buffer)?;
    Ok(bytemuck::pod_collect_to_vec(&bytes[..bytes.len() / size_of::<T>() * size_of::<T>()]))
}
