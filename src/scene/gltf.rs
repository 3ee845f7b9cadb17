//! glTF 2.0 files: which nodes show which primitives, posed and classified, as parts of a scene.

use super::assemble::{Part, Surroundings, assemble, build, tidy};
use super::deform::{Deform, Skin};
use super::file::{File, find, label};
use super::materials::{Materials, Visibility};
use super::motion::{How, Motion, Moves, reach};
use super::nodes::Tree;
use super::pose::{Pose, Rig};
use super::primitive::{Geometry, has_triangles, read};
use super::{LoadOptions, Scene, SceneError};
use ::gltf::json::mesh::Primitive;
use glam::{DAffine3, DMat3, DVec3, Vec3};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

pub(super) fn load(path: &Path, options: &LoadOptions) -> Result<Scene, SceneError> {
    let loaded = Content::read(path, options, false).and_then(|c| assemble(c.parts, c.rest));
    loaded.map_err(|what| SceneError { path: path.display().to_string(), what })
}

pub(super) fn load_moving(path: &Path, options: &LoadOptions) -> Result<(Scene, Option<Motion>), SceneError> {
    let named = |what| SceneError { path: path.display().to_string(), what };
    let Content { mut parts, mut rest, rig } = Content::read(path, options, true).map_err(named)?;
    tidy(&mut parts, &mut rest.warnings).map_err(named)?;
    reach(&rig, &mut parts, options.time_s).map_err(named)?;
    let (scene, placed) = build(parts, rest).map_err(named)?;
    let motion = (!placed.is_empty()).then(|| Motion::animated(&scene, path.display().to_string(), rig, placed));
    Ok((scene, motion))
}

/// A file read into parts.
struct Content {
    parts: Vec<Part>,
    rest: Surroundings,
    rig: Rig,
}

impl Content {
    /// With `moving` the parts know what the animation does to them.
    fn read(path: &Path, options: &LoadOptions, moving: bool) -> Result<Self, String> {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let file = File::open(path)?;
        let tree = Tree::new(&file)?;
        let rig = Rig::new(&file, &tree)?;
        let pose = rig.pose(options.time_s)?;
        let mut warnings = Vec::new();
        let jobs = jobs(&file, &tree, &mut warnings)?;
        let used: BTreeSet<Option<usize>> = jobs.iter().map(|j| j.primitive.material.map(|m| m.value())).collect();
        let materials = Materials::read(&file, &used, options.blend, &mut warnings)?;
        let moving = moving.then(|| rig.moving());
        let context = Context { file: &file, rig: &rig, pose: &pose, materials: &materials, options, moving };
        let outcomes: Vec<Outcome> = jobs
            .par_iter()
            .map(|job| job.run(&context).map_err(|e| format!("{}: {e}", job.name)))
            .collect::<Result<_, _>>()?;
        let mut parts = Vec::new();
        for outcome in outcomes {
            parts.extend(outcome.parts);
            warnings.extend(outcome.warnings);
        }
        let (materials, texels) = materials.finish()?;
        Ok(Self { parts, rest: Surroundings { name, materials, texels, warnings }, rig })
    }
}

/// What all jobs read.
struct Context<'a> {
    file: &'a File,
    rig: &'a Rig,
    pose: &'a Pose,
    materials: &'a Materials,
    options: &'a LoadOptions,
    /// Nodes that the animation moves, where motion is kept.
    moving: Option<Vec<bool>>,
}

impl Context<'_> {
    fn moves(&self, node: usize) -> bool {
        self.moving.as_ref().is_some_and(|m| m.get(node).copied().unwrap_or(false))
    }
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

/// World positions, and what deforms them over time.
type Posed = (Vec<DVec3>, Option<How>);

impl Job<'_> {
    fn run(&self, context: &Context) -> Result<Outcome, String> {
        let index = self.primitive.material.map(|m| m.value());
        let (material, surface) = context.materials.get(index).ok_or("its material was not read")?;
        let geometry = read(context.file, self.primitive, surface.uv_set)?;
        let mut outcome = Outcome::default();
        if geometry.lacks_uv {
            outcome.warn(self, "the texture coordinates of its material are missing and count as 0");
        }
        let visibility = context.materials.visibility(material, geometry.alpha);
        if visibility == Visibility::Nothing {
            outcome.warn(self, "alpha is below the cutoff everywhere, so it was left out");
            return Ok(outcome);
        }
        let part = |positions: Vec<DVec3>, instances: Vec<DAffine3>, how: Option<How>| Part {
            positions,
            attributes: geometry.attributes.clone(),
            triangles: geometry.triangles.clone(),
            material,
            casts: surface.casts(context.options.blend),
            alpha_tested: visibility == Visibility::Tested,
            instances,
            group: self.mesh,
            moves: how.map(Moves::new),
        };
        let mut rigid = Vec::new();
        for &node in &self.nodes {
            match self.posed(context, &geometry, node).map_err(|e| format!("node {node}: {e}"))? {
                Some((positions, how)) => outcome.parts.push(part(positions, Vec::new(), how)),
                None => rigid.push((node, context.pose.worlds[node])),
            }
        }
        let shown = rigid.len();
        rigid.retain(|(node, m)| m.matrix3 != DMat3::ZERO || context.moves(*node));
        if rigid.len() < shown {
            outcome.warn(self, "instances of scale 0 were left out");
        }
        if !rigid.is_empty() {
            let positions = geometry.rest.positions.iter().map(|p| Vec3::from(*p).as_dvec3()).collect();
            let moving = |(i, (node, _)): (u32, &(usize, DAffine3))| context.moves(*node).then_some((i, *node));
            let nodes: Vec<(u32, usize)> = (0..).zip(&rigid).filter_map(moving).collect();
            let how = (!nodes.is_empty()).then_some(How::Rigid { nodes, centre: DVec3::ZERO });
            outcome.parts.insert(0, part(positions, rigid.into_iter().map(|(_, m)| m).collect(), how));
        }
        Ok(outcome)
    }

    /// The primitive as this node shows it, or `None` where the node's matrix alone moves it.
    fn posed(&self, context: &Context, geometry: &Geometry, node: usize) -> Result<Option<Posed>, String> {
        let Context { file, rig, pose, .. } = context;
        let rest = &geometry.rest;
        let skin = match (file.root.nodes[node].skin, &rest.binding) {
            (Some(skin), Some(_)) => Some(Skin::read(file, skin.value())?),
            _ => None,
        };
        let stored = || file.root.meshes[self.mesh].weights.iter().flatten().map(|w| f64::from(*w)).collect();
        let weights: Vec<f64> = pose.weights[node].clone().unwrap_or_else(stored);
        let morphs = context.moving.is_some() && rest.has_targets() && rig.morphs(node);
        let moved = rest.targets.iter().zip(&weights).any(|(t, w)| *w != 0.0 && !t.is_empty());
        if !moved && !morphs && skin.is_none() {
            return Ok(None);
        }
        let positions = rest.place(pose, node, &weights, skin.as_ref())?;
        let carried = skin.as_ref().map_or(context.moves(node), |s| s.joints.iter().any(|j| context.moves(*j)));
        let deform = || Deform { rest: rest.clone(), node, weights: stored(), skin };
        let how = (morphs || carried).then(|| How::Deforms(Box::new(deform())));
        Ok(Some((positions, how)))
    }
}

impl Outcome {
    fn warn(&mut self, job: &Job, what: &str) {
        self.warnings.push(format!("{}: {what}", job.name));
    }
}
