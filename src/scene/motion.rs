//! Scenes that move: where everything is at a time, written into a [`Scene`] in place.

mod orbits;
mod reach;

pub(super) use reach::reach;

use super::assemble::{Bounds, EMPTY, placed};
use super::deform::Deform;
use super::pose::Rig;
use super::{Cluster, Scene, SceneError};
use crate::casters;
use glam::{DAffine3, DVec3};
use orbits::Orbit;
use rayon::prelude::*;
use std::ops::Range;

/// Vertices or clusters that stayed between two changed runs of a mesh, up to which they count as one run.
const GAP: usize = 64;

/// What an animation does to a part.
pub(super) struct Moves {
    /// World bounds of the part over all times.
    pub(super) bounds: Bounds,
    pub(super) how: How,
}

/// Whether matrices move a part or its vertices move one by one.
pub(super) enum How {
    /// Instances, numbered within the part, with the node that moves each; zero of the part in the node's space.
    Rigid {
        nodes: Vec<(u32, usize)>,
        centre: DVec3,
    },
    Deforms(Box<Deform>),
}

impl Moves {
    pub(super) fn new(how: How) -> Self {
        Self { bounds: EMPTY, how }
    }

    pub(super) fn deform(&mut self) -> Option<&mut Deform> {
        match &mut self.how {
            How::Deforms(deform) => Some(deform),
            How::Rigid { .. } => None,
        }
    }
}

/// Something that moves, and where it lies in the scene.
pub(super) enum Placed {
    Rigid { instance: u32, node: usize, centre: DVec3 },
    Deform { mesh: u32, first_vertex: u32, deform: Box<Deform> },
}

/// What moves a scene. It belongs to the scene that it was made with.
pub struct Motion {
    kind: Kind,
    shape: Shape,
}

enum Kind {
    File {
        path: String,
        rig: Rig,
        placed: Vec<Placed>,
    },
    /// The first of a run of instances, one an orbit.
    Orbits {
        first: u32,
        orbits: Vec<Orbit>,
    },
}

/// Numbers of instances, vertices, clusters and meshes: what tells that a scene is another one.
#[derive(PartialEq, Eq)]
struct Shape([usize; 4]);

impl Shape {
    fn of(scene: &Scene) -> Self {
        Self([scene.instances.len(), scene.positions.len(), scene.clusters.len(), scene.meshes.len()])
    }
}

/// What posing a scene changed; all lists ascend.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Changes {
    /// Entries of [`Scene::instances`]: those that moved and those whose mesh deformed.
    pub instances: Vec<u32>,
    /// Runs of [`Scene::positions`].
    pub vertices: Vec<Range<u32>>,
    /// Runs of [`Scene::clusters`]: their bounds.
    pub clusters: Vec<Range<u32>>,
    /// Entries of [`Scene::meshes`] that deformed.
    pub meshes: Vec<u32>,
}

impl Changes {
    /// Whether nothing changed.
    pub fn is_empty(&self) -> bool {
        self.instances.is_empty() && self.vertices.is_empty()
    }
}

/// A pose computed but not yet written.
#[derive(Default)]
struct Next {
    matrices: Vec<(u32, DAffine3)>,
    /// Mesh, first vertex, positions.
    positions: Vec<(u32, u32, Vec<[f32; 3]>)>,
}

impl Motion {
    pub(super) fn animated(scene: &Scene, path: String, rig: Rig, placed: Vec<Placed>) -> Self {
        Self { kind: Kind::File { path, rig, placed }, shape: Shape::of(scene) }
    }

    /// Length in seconds after which everything stands as at time 0; 0 where the animation has only one key time.
    pub fn period_s(&self) -> f64 {
        match &self.kind {
            Kind::File { rig, .. } => rig.duration,
            Kind::Orbits { .. } => orbits::PERIOD_S * orbits::SLOW_PERIODS,
        }
    }

    /// Brings the scene to a time, which wraps around like [`super::LoadOptions::time_s`].
    ///
    /// Written are the rows of instances that move, the positions of parts that deform and the bounds of their clusters.
    /// Every changed instance gets the next `revision`. What stays bit for bit is not reported.
    ///
    /// # Errors
    /// `time_s` is not finite, something would get a place that is not finite, or the scene is not the motion's own. The
    /// scene is then as before.
    pub fn pose(&self, scene: &mut Scene, time_s: f64) -> Result<Changes, SceneError> {
        let named = |what| {
            let path = match &self.kind {
                Kind::File { path, .. } => path.clone(),
                Kind::Orbits { .. } => scene.name.clone(),
            };
            SceneError { path, what }
        };
        if Shape::of(scene) != self.shape {
            return Err(named("the motion was made with another scene".to_string()));
        }
        if !time_s.is_finite() {
            return Err(named(format!("the time is {time_s} s; it must be finite")));
        }
        let next = match &self.kind {
            Kind::File { rig, placed, .. } => animate(rig, placed, scene.origin, time_s).map_err(named)?,
            Kind::Orbits { first, orbits } => Next {
                matrices: (*first..).zip(orbits).map(|(i, o)| (i, o.at(time_s))).collect(),
                positions: Vec::new(),
            },
        };
        let matrices = next.matrices.iter().flat_map(|(_, matrix)| matrix.to_cols_array().map(|v| v as f32));
        let corners = next.positions.iter().flat_map(|(_, _, list)| list.as_flattened());
        if let Some(value) = matrices.chain(corners.copied()).find(|v| !v.is_finite()) {
            return Err(named(format!("a place is {value} in single precision; it must be finite")));
        }
        Ok(next.write(scene))
    }
}

fn animate(rig: &Rig, parts: &[Placed], origin: DVec3, time_s: f64) -> Result<Next, String> {
    let pose = rig.pose(time_s)?;
    let mut next = Next::default();
    for part in parts {
        if let Placed::Rigid { instance, node, centre } = part {
            let matrix = pose.worlds[*node] * DAffine3::from_translation(*centre);
            next.matrices.push((*instance, matrix));
        }
    }
    let deformed = parts.par_iter().filter_map(|part| match part {
        Placed::Deform { mesh, first_vertex, deform } => Some(deform.place(&pose).map(|positions| {
            let positions = positions.iter().map(|p| (*p - origin).as_vec3().to_array()).collect();
            (*mesh, *first_vertex, positions)
        })),
        Placed::Rigid { .. } => None,
    });
    next.positions = deformed.collect::<Result<_, String>>()?;
    Ok(next)
}

impl Next {
    fn write(self, scene: &mut Scene) -> Changes {
        let mut changes = Changes::default();
        for (i, matrix) in self.matrices {
            let instance = &mut scene.instances[i as usize];
            let moved = placed(*instance, &matrix, scene.origin);
            if bytemuck::bytes_of(instance) != bytemuck::bytes_of(&moved) {
                *instance = moved;
                changes.instances.push(i);
            }
        }
        for (number, first_vertex, positions) in self.positions {
            let runs = replace(&mut scene.positions, first_vertex, &positions);
            if runs.is_empty() {
                continue;
            }
            changes.vertices.extend(runs);
            changes.meshes.push(number);
            let mesh = scene.meshes[number as usize];
            changes.instances.extend(mesh.first_instance..mesh.first_instance + mesh.instance_count);
            let first = mesh.first_cluster as usize;
            let bound = |cluster: &Cluster| {
                let indices = &scene.indices[cluster.first_index as usize..][..cluster.triangle_count as usize * 3];
                casters::bound(&scene.positions, indices.as_chunks::<3>().0, cluster.first_index)
            };
            let bounds: Vec<Cluster> =
                scene.clusters[first..first + mesh.cluster_count as usize].iter().map(bound).collect();
            changes.clusters.extend(replace(&mut scene.clusters, mesh.first_cluster, &bounds));
        }
        changes.instances.sort_unstable();
        for &i in &changes.instances {
            let revision = &mut scene.instances[i as usize].revision;
            *revision = revision.wrapping_add(1);
        }
        changes
    }
}

/// Overwrites a stretch of `list` and returns the runs that changed.
fn replace<T: bytemuck::Pod>(list: &mut [T], first: u32, new: &[T]) -> Vec<Range<u32>> {
    let old = &mut list[first as usize..][..new.len()];
    let mut runs: Vec<Range<u32>> = Vec::new();
    for (i, (old, new)) in (first..).zip(old.iter_mut().zip(new)) {
        if bytemuck::bytes_of(old) == bytemuck::bytes_of(new) {
            continue;
        }
        *old = *new;
        match runs.last_mut() {
            Some(run) if (i - run.end) as usize <= GAP => run.end = i + 1,
            _ => runs.push(i..i + 1),
        }
    }
    runs
}
