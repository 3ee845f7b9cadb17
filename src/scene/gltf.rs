//! glTF 2.0 files: which nodes show which primitives, posed and classified, as parts of a scene.

use super::assemble::{Part, Surroundings, assemble};
use super::file::{File, find, label};
use super::materials::{Materials, Visibility};
use super::nodes::Tree;
use super::pose::{Pose, morph};
use super::primitive::{Geometry, has_triangles, read};
use super::{LoadOptions, Scene, SceneError};
use ::gltf::json::mesh::Primitive;
use glam::{DAffine3, DMat3, DVec3, Vec3};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

pub(super) fn load(path: &Path, options: &LoadOptions) -> Result<Scene, SceneError> {
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    load_named(path, name, options).map_err(|what| SceneError { path: path.display().to_string(), what })
}

fn load_named(path: &Path, name: String, options: &LoadOptions) -> Result<Scene, String> {
    let file = File::open(path)?;
    let tree = Tree::new(&file)?;
    let pose = Pose::new(&file, &tree, options.time_s)?;
    let mut warnings = Vec::new();
    let jobs = jobs(&file, &tree, &mut warnings)?;
    let used: BTreeSet<Option<usize>> = jobs.iter().map(|j| j.primitive.material.map(|m| m.value())).collect();
    let materials = Materials::read(&file, &used, &mut warnings)?;
    let outcomes: Vec<Outcome> = jobs
        .par_iter()
        .map(|job| job.run(&file, &pose, &materials, options).map_err(|e| format!("{}: {e}", job.name)))
        .collect::<Result<_, _>>()?;
    let mut parts = Vec::new();
    for outcome in outcomes {
        parts.extend(outcome.parts);
        warnings.extend(outcome.warnings);
    }
    let (materials, texels) = materials.finish()?;
    assemble(parts, Surroundings { name, materials, texels, warnings })
}

/// A primitive and the nodes that show it.
struct Job<'a> {
    name: String,
    mesh: usize,
    primitive: &'a Primitive,
    nodes: Vec<usize>,
}

/// What a job gives: parts, and sentences on what it left out.
#[derive(Default)]
struct Outcome {
    parts: Vec<Part>,
    warnings: Vec<String>,
}

/// Primitives with triangles of all shown meshes, in file order.
fn jobs<'a>(file: &'a File, tree: &Tree, warnings: &mut Vec<String>) -> Result<Vec<Job<'a>>, String> {
    let mut jobs = Vec::new();
    for (mesh, nodes) in shown_meshes(file, tree)? {
        let json = &file.root.meshes[mesh];
        for (i, primitive) in json.primitives.iter().enumerate() {
            let name = format!("{}, primitive {i}", label("mesh", mesh, json.name.as_ref()));
            match has_triangles(primitive).map_err(|e| format!("{name}: {e}"))? {
                true => jobs.push(Job { name, mesh, primitive, nodes: nodes.clone() }),
                false => warnings.push(format!("{name}: points and lines were left out")),
            }
        }
    }
    Ok(jobs)
}

fn shown_meshes(file: &File, tree: &Tree) -> Result<BTreeMap<usize, Vec<usize>>, String> {
    let mut meshes: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for &node in &tree.shown {
        if let Some(mesh) = file.root.nodes[node].mesh {
            find(&file.root.meshes, mesh.value(), "mesh")?;
            meshes.entry(mesh.value()).or_default().push(node);
        }
    }
    Ok(meshes)
}

impl Job<'_> {
    fn run(&self, file: &File, pose: &Pose, materials: &Materials, options: &LoadOptions) -> Result<Outcome, String> {
        let index = self.primitive.material.map(|m| m.value());
        let (material, surface) = materials.get(index).ok_or("its material was not read")?;
        let geometry = read(file, self.primitive, surface.uv_set)?;
        let mut outcome = Outcome::default();
        if geometry.lacks_uv {
            outcome.warn(self, "the texture coordinates of its material are missing and count as 0");
        }
        let visibility = materials.visibility(material, geometry.alpha);
        if visibility == Visibility::Nothing {
            outcome.warn(self, "alpha is below the cutoff everywhere, so it was left out");
            return Ok(outcome);
        }
        let part = |positions: Vec<DVec3>, instances: Vec<DAffine3>| Part {
            positions,
            attributes: geometry.attributes.clone(),
            triangles: geometry.triangles.clone(),
            material,
            casts: surface.casts(options),
            alpha_tested: visibility == Visibility::Tested,
            instances,
            group: self.mesh,
        };
        let mut rigid = Vec::new();
        for &node in &self.nodes {
            match posed(file, pose, &geometry, node, self.mesh).map_err(|e| format!("node {node}: {e}"))? {
                Some(positions) => outcome.parts.push(part(positions, Vec::new())),
                None => rigid.push(pose.worlds[node]),
            }
        }
        let shown = rigid.len();
        rigid.retain(|m| m.matrix3 != DMat3::ZERO);
        if rigid.len() < shown {
            outcome.warn(self, "instances of scale 0 were left out");
        }
        if !rigid.is_empty() {
            let positions = geometry.positions.iter().map(|p| Vec3::from(*p).as_dvec3()).collect();
            outcome.parts.insert(0, part(positions, rigid));
        }
        Ok(outcome)
    }
}

impl Outcome {
    fn warn(&mut self, job: &Job, what: &str) {
        self.warnings.push(format!("{}: {what}", job.name));
    }
}

/// World positions as this node shows them, or `None` where its matrix alone moves the primitive.
fn posed(
    file: &File,
    pose: &Pose,
    geometry: &Geometry,
    node: usize,
    mesh: usize,
) -> Result<Option<Vec<DVec3>>, String> {
    let weights = pose.weights(file, node, mesh);
    let skin = file.root.nodes[node].skin;
    let moved = geometry.targets.iter().zip(&weights).any(|(t, w)| *w != 0.0 && !t.is_empty());
    if !moved && (skin.is_none() || geometry.binding.is_none()) {
        return Ok(None);
    }
    let mut positions: Vec<DVec3> = geometry.positions.iter().map(|p| Vec3::from(*p).as_dvec3()).collect();
    morph(&mut positions, &geometry.targets, &weights);
    match (skin, &geometry.binding) {
        (Some(skin), Some(binding)) => binding.apply(&mut positions, &pose.joints(file, skin.value())?)?,
        _ => positions.iter_mut().for_each(|p| *p = pose.worlds[node].transform_point3(*p)),
    }
    match positions.iter().position(|p| !p.is_finite()) {
        Some(vertex) => Err(format!("vertex {vertex} is posed at {}; it must be finite", positions[vertex])),
        None => Ok(Some(positions)),
    }
}
