//! Parts in double precision in, a [`Scene`] around its own centre out.

use super::{Attributes, Cluster, Instance, Material, Mesh, Scene, clusters};
use crate::host::{ALPHA_TESTED, CastPolicy};
use glam::{DAffine3, DVec3};
use rayon::prelude::*;

/// Vertices times instances up to which the world bounds are exact; beyond, boxes are transformed.
const EXACT_VERTICES: u64 = 20_000_000;
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
}

/// Everything of a scene but the parts.
pub(super) struct Surroundings {
    pub(super) name: String,
    pub(super) materials: Vec<Material>,
    pub(super) texels: Vec<u32>,
    pub(super) warnings: Vec<String>,
}

/// Drops degenerate triangles and unused vertices, moves the origin, cuts clusters.
pub(super) fn assemble(mut parts: Vec<Part>, rest: Surroundings) -> Result<Scene, String> {
    let Surroundings { name, materials, texels, mut warnings } = rest;
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
    recentre(&mut parts);
    let (bounds_min, bounds_max) = world_bounds(&parts);
    let diagonal = (bounds_max - bounds_min).length();
    if !(diagonal > 0.0 && diagonal <= MAX_DIAGONAL) {
        return Err(format!("the bounds have a diagonal of {diagonal}; allowed is more than 0 up to {MAX_DIAGONAL}"));
    }
    let origin = (bounds_min + bounds_max) * 0.5;
    let mut scene = Scene { name, origin, materials, texels, bounds_min, bounds_max, warnings, ..Scene::default() };
    let finished: Vec<Finished> = parts.par_iter().map(|part| finish(part, origin)).collect();
    for (part, finished) in parts.iter().zip(finished) {
        append(&mut scene, part, finished);
    }
    match scene.instances.iter().flat_map(|i| i.rows.as_flattened()).find(|v| !v.is_finite()) {
        Some(value) => Err(format!("an instance's matrix holds {value} in single precision; it must be finite")),
        None => Ok(scene),
    }
}

/// Removes triangles of zero area and vertices without a triangle; returns how many triangles went.
fn clean(part: &mut Part) -> usize {
    let before = part.triangles.len();
    let positions = &part.positions;
    part.triangles.retain(|t| {
        let [a, b, c] = t.map(|i| positions[i as usize]);
        (b - a).cross(c - a) != DVec3::ZERO
    });
    let order = renumber(&mut part.triangles, part.positions.len());
    part.positions = pick(&part.positions, &order);
    part.attributes = pick(&part.attributes, &order);
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

fn bounds(points: impl Iterator<Item = DVec3>) -> (DVec3, DVec3) {
    points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)))
}

/// Moves mesh space to the middle of the mesh where it lies further from zero than it is large.
fn recentre(parts: &mut [Part]) {
    let groups = parts.iter().map(|p| p.group + 1).max().unwrap_or(0);
    let mut boxes = vec![(DVec3::INFINITY, DVec3::NEG_INFINITY); groups];
    for part in parts.iter().filter(|p| !p.instances.is_empty()) {
        let (low, high) = bounds(part.positions.iter().copied());
        let (group_low, group_high) = &mut boxes[part.group];
        (*group_low, *group_high) = (group_low.min(low), group_high.max(high));
    }
    parts.par_iter_mut().filter(|p| !p.instances.is_empty()).for_each(|part| {
        let (low, high) = boxes[part.group];
        let centre = (low + high) * 0.5;
        if centre.abs().max_element() > (high - low).max_element() {
            part.positions.iter_mut().for_each(|p| *p -= centre);
            part.instances.iter_mut().for_each(|m| *m *= DAffine3::from_translation(centre));
        }
    });
}

fn world_bounds(parts: &[Part]) -> (DVec3, DVec3) {
    let work: u64 = parts.iter().map(|p| p.positions.len() as u64 * p.instances.len() as u64).sum();
    let boxes = parts.par_iter().map(|part| {
        if part.instances.is_empty() {
            return bounds(part.positions.iter().copied());
        }
        let corners = if work > EXACT_VERTICES { corners(part) } else { Vec::new() };
        let points = if corners.is_empty() { &part.positions } else { &corners };
        bounds(part.instances.iter().flat_map(|m| points.iter().map(|p| m.transform_point3(*p))))
    });
    boxes.reduce(|| (DVec3::INFINITY, DVec3::NEG_INFINITY), |a, b| (a.0.min(b.0), a.1.max(b.1)))
}

fn corners(part: &Part) -> Vec<DVec3> {
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
}

fn finish(part: &Part, origin: DVec3) -> Finished {
    let shift = if part.instances.is_empty() { origin } else { DVec3::ZERO };
    let positions: Vec<[f32; 3]> = part.positions.iter().map(|p| (*p - shift).as_vec3().to_array()).collect();
    let mut triangles = part.triangles.clone();
    let clusters = clusters::build(&positions, &mut triangles);
    // vertices in the order the clusters read them
    let order = renumber(&mut triangles, positions.len());
    Finished { positions: pick(&positions, &order), attributes: pick(&part.attributes, &order), triangles, clusters }
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
    let flags = policy as u32 | u32::from(part.alpha_tested) * ALPHA_TESTED;
    let place = |m: &DAffine3| Instance { rows: rows(m, origin), material: part.material, mesh, revision: 0, flags };
    scene.instances.extend(instances.iter().map(place));
}

/// Rows of the 3x4 matrix relative to the origin, rounded last.
fn rows(matrix: &DAffine3, origin: DVec3) -> [[f32; 4]; 3] {
    let translation = matrix.translation - origin;
    std::array::from_fn(|i| matrix.matrix3.row(i).extend(translation[i]).as_vec4().to_array())
}
