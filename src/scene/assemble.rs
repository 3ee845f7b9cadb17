//! Parts in double precision in, a [`Scene`] around its own centre out.

use super::motion::{How, Moves, Placed};
use super::{Attributes, Cluster, Instance, Material, Mesh, Scene};
use crate::casters;
use crate::casters::{ALPHA_TESTED, CastPolicy};
use glam::{DAffine3, DVec3};
use rayon::prelude::*;

/// Vertices times instances up to which the world bounds are exact; beyond, boxes are transformed.
pub(super) const EXACT_VERTICES: u64 = 20_000_000;
/// Largest diagonal whose square is finite in single precision.
const MAX_DIAGONAL: f64 = 1e18;
/// Most triangles stored: all indices fit 32 bits with room to spare.
const MAX_TRIANGLES: u64 = 1 << 28;

/// Triangles with one material.
pub(super) struct Part {
    /// Mesh space; world space where `instances` is empty.
    pub(super) positions: Vec<DVec3>,
    /// Parallel to `positions`.
    pub(super) attributes: Vec<Attributes>,
    /// Corners, indices into `positions`.
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) material: u32,
    pub(super) casts: bool,
    pub(super) alpha_tested: bool,
    /// Placements; none for a posed part, which then gets one identity instance.
    pub(super) instances: Vec<DAffine3>,
    /// Parts with the same number are recentred alike, so that edges they share stay shared.
    pub(super) group: usize,
    /// What an animation does to the part, where motion is kept.
    pub(super) moves: Option<Moves>,
}

/// Everything of a scene but the parts.
pub(super) struct Surroundings {
    pub(super) name: String,
    pub(super) materials: Vec<Material>,
    pub(super) texels: Vec<u32>,
    pub(super) warnings: Vec<String>,
}

/// Drops degenerate triangles and unused vertices, moves the origin, cuts clusters.
pub(super) fn assemble(mut parts: Vec<Part>, mut rest: Surroundings) -> Result<Scene, String> {
    tidy(&mut parts, &mut rest.warnings)?;
    build(parts, rest).map(|(scene, _)| scene)
}

/// Drops degenerate triangles, unused vertices and parts without triangles.
pub(super) fn tidy(parts: &mut Vec<Part>, warnings: &mut Vec<String>) -> Result<(), String> {
    let dropped: usize = parts.par_iter_mut().map(clean).sum();
    parts.retain(|part| !part.triangles.is_empty());
    let triangles: u64 = parts.iter().map(|p| p.triangles.len() as u64).sum();
    match (triangles, dropped) {
        (0, 0) => return Err("the scene has no triangles".to_string()),
        (0, n) => return Err(format!("all {n} triangles of the scene have zero area")),
        (n, _) if n > MAX_TRIANGLES => return Err(format!("the scene has {n} triangles; at most {MAX_TRIANGLES} fit")),
        (_, 0) => {}
        (_, n) => warnings.push(format!("{n} triangles of zero area were dropped")),
    }
    Ok(())
}

/// A scene of tidy parts, one mesh each, and where the parts that move lie in it.
pub(super) fn build(mut parts: Vec<Part>, rest: Surroundings) -> Result<(Scene, Vec<Placed>), String> {
    recentre(&mut parts);
    let (bounds_min, bounds_max) = world_bounds(&parts);
    let diagonal = (bounds_max - bounds_min).length();
    if !(diagonal > 0.0 && diagonal <= MAX_DIAGONAL) {
        return Err(format!("the bounds have a diagonal of {diagonal}; allowed is more than 0 up to {MAX_DIAGONAL}"));
    }
    let origin = (bounds_min + bounds_max) * 0.5;
    let Surroundings { name, materials, texels, warnings } = rest;
    let mut scene = Scene { name, origin, materials, texels, bounds_min, bounds_max, warnings, ..Scene::default() };
    let finished: Vec<Finished> = parts.par_iter().map(|part| finish(part, origin)).collect();
    let mut placed = Vec::new();
    for (mut part, finished) in parts.into_iter().zip(finished) {
        let (mesh, first_vertex) = (scene.meshes.len() as u32, scene.positions.len() as u32);
        match part.moves.take().map(|moves| moves.how) {
            Some(How::Deforms(mut deform)) => {
                deform.rest.pick(&finished.order);
                placed.push(Placed::Deform { mesh, first_vertex, deform });
            }
            Some(How::Rigid { nodes, centre }) => {
                let first = scene.instances.len() as u32;
                placed.extend(nodes.iter().map(|&(i, node)| Placed::Rigid { instance: first + i, node, centre }));
            }
            None => {}
        }
        append(&mut scene, &part, finished);
    }
    match scene.instances.iter().flat_map(|i| i.rows.as_flattened()).find(|v| !v.is_finite()) {
        Some(value) => Err(format!("an instance's matrix holds {value} in single precision; it must be finite")),
        None => Ok((scene, placed)),
    }
}

/// Appends a part of its own placements to a scene whose origin stays.
pub(super) fn add(scene: &mut Scene, mut part: Part) {
    clean(&mut part);
    let finished = finish(&part, scene.origin);
    append(scene, &part, finished);
}

/// Removes triangles of zero area and vertices without a triangle; returns how many triangles went. Where vertices
/// move on their own, only triangles that never have an area go.
fn clean(part: &mut Part) -> usize {
    let before = part.triangles.len();
    let positions = &part.positions;
    let deform = part.moves.as_mut().and_then(Moves::deform);
    part.triangles.retain(|t| {
        let [a, b, c] = t.map(|i| positions[i as usize]);
        match deform {
            Some(_) => t[0] != t[1] && t[1] != t[2] && t[2] != t[0],
            None => (b - a).cross(c - a) != DVec3::ZERO,
        }
    });
    let order = renumber(&mut part.triangles, part.positions.len());
    part.positions = pick(&part.positions, &order);
    part.attributes = pick(&part.attributes, &order);
    if let Some(deform) = deform {
        deform.rest.pick(&order);
    }
    before - part.triangles.len()
}

/// Renumbers corners in order of first use; returns the old number of each new one.
fn renumber(triangles: &mut [[u32; 3]], vertices: usize) -> Vec<u32> {
    let mut number = vec![u32::MAX; vertices];
    let mut order = Vec::new();
    for corner in triangles.as_flattened_mut() {
        let new = &mut number[*corner as usize];
        if *new == u32::MAX {
            *new = order.len() as u32;
            order.push(*corner);
        }
        *corner = *new;
    }
    order
}

fn pick<T: Copy>(list: &[T], order: &[u32]) -> Vec<T> {
    order.iter().map(|&i| list[i as usize]).collect()
}

/// Lower and upper corner of a box in world or mesh space.
pub(super) type Bounds = (DVec3, DVec3);

/// The box of no points.
pub(super) const EMPTY: Bounds = (DVec3::INFINITY, DVec3::NEG_INFINITY);

pub(super) fn bounds(points: impl Iterator<Item = DVec3>) -> Bounds {
    points.fold(EMPTY, |(low, high), p| (low.min(p), high.max(p)))
}

/// The box around both.
pub(super) fn union(a: Bounds, b: Bounds) -> Bounds {
    (a.0.min(b.0), a.1.max(b.1))
}

/// Moves mesh space to the middle of the mesh where it lies further from zero than it is large.
fn recentre(parts: &mut [Part]) {
    let groups = parts.iter().map(|p| p.group + 1).max().unwrap_or(0);
    let mut boxes = vec![EMPTY; groups];
    for part in parts.iter().filter(|p| !p.instances.is_empty()) {
        boxes[part.group] = union(boxes[part.group], bounds(part.positions.iter().copied()));
    }
    parts.par_iter_mut().filter(|p| !p.instances.is_empty()).for_each(|part| {
        let (low, high) = boxes[part.group];
        let centre = (low + high) * 0.5;
        if centre.abs().max_element() > (high - low).max_element() {
            part.positions.iter_mut().for_each(|p| *p -= centre);
            part.instances.iter_mut().for_each(|m| *m *= DAffine3::from_translation(centre));
            if let Some(Moves { how: How::Rigid { centre: moved, .. }, .. }) = &mut part.moves {
                *moved = centre;
            }
        }
    });
}

fn world_bounds(parts: &[Part]) -> Bounds {
    let work: u64 = parts.iter().map(|p| p.positions.len() as u64 * p.instances.len() as u64).sum();
    let boxes = parts.par_iter().map(|part| {
        if let Some(moves) = &part.moves {
            return moves.bounds;
        }
        if part.instances.is_empty() {
            return bounds(part.positions.iter().copied());
        }
        let corners = if work > EXACT_VERTICES { corners(part) } else { Vec::new() };
        let points = if corners.is_empty() { &part.positions } else { &corners };
        bounds(part.instances.iter().flat_map(|m| points.iter().map(|p| m.transform_point3(*p))))
    });
    boxes.reduce(|| EMPTY, union)
}

/// Corners of the box around the part in its own space.
pub(super) fn corners(part: &Part) -> Vec<DVec3> {
    let (low, high) = bounds(part.positions.iter().copied());
    let end = |i: u32, axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
    (0..8).map(|i| DVec3::new(end(i, 0), end(i, 1), end(i, 2))).collect()
}

/// A part in single precision, numbered from zero.
struct Finished {
    positions: Vec<[f32; 3]>,
    attributes: Vec<Attributes>,
    triangles: Vec<[u32; 3]>,
    clusters: Vec<Cluster>,
    /// The part's vertex behind each stored one; empty where nothing moves the part.
    order: Vec<u32>,
}

fn finish(part: &Part, origin: DVec3) -> Finished {
    let shift = if part.instances.is_empty() { origin } else { DVec3::ZERO };
    let positions: Vec<[f32; 3]> = part.positions.iter().map(|p| (*p - shift).as_vec3().to_array()).collect();
    let mut triangles = part.triangles.clone();
    let clusters = casters::build(&positions, &mut triangles);
    // vertices in the order the clusters read them
    let order = renumber(&mut triangles, positions.len());
    let (positions, attributes) = (pick(&positions, &order), pick(&part.attributes, &order));
    let order = if part.moves.is_some() { order } else { Vec::new() };
    Finished { positions, attributes, triangles, clusters, order }
}

fn append(scene: &mut Scene, part: &Part, finished: Finished) {
    let base = scene.positions.len() as u32;
    let first_index = scene.indices.len() as u32;
    let mesh = scene.meshes.len() as u32;
    let identity = [DAffine3::IDENTITY];
    let (instances, origin) = match part.instances.is_empty() {
        true => (&identity[..], DVec3::ZERO),
        false => (&part.instances[..], scene.origin),
    };
    scene.meshes.push(Mesh {
        first_index,
        index_count: finished.triangles.len() as u32 * 3,
        first_cluster: scene.clusters.len() as u32,
        cluster_count: finished.clusters.len() as u32,
        material: part.material,
        first_instance: scene.instances.len() as u32,
        instance_count: instances.len() as u32,
        casts: part.casts,
        alpha_tested: part.alpha_tested,
    });
    scene.positions.extend(finished.positions);
    scene.attributes.extend(finished.attributes);
    scene.indices.extend(finished.triangles.iter().flatten().map(|i| base + i));
    scene.clusters.extend(finished.clusters.iter().map(|c| Cluster { first_index: first_index + c.first_index, ..*c }));
    let policy = if part.casts { CastPolicy::Auto } else { CastPolicy::Never };
    let flags = policy as u32 | (u32::from(part.alpha_tested) * ALPHA_TESTED);
    let placed = |matrix: &DAffine3| {
        let from_origin = DAffine3 { translation: matrix.translation - origin, ..*matrix };
        Instance { flags, ..Instance::new(&from_origin, mesh, part.material) }
    };
    scene.instances.extend(instances.iter().map(placed));
}

/// An instance with the matrix relative to the origin, rounded last.
pub(super) fn placed(mut instance: Instance, matrix: &DAffine3, origin: DVec3) -> Instance {
    instance.rows = std::array::from_fn(|i| matrix.matrix3.row(i).extend(0.0).as_vec4().to_array());
    instance.set_translation(matrix.translation - origin);
    instance
}
