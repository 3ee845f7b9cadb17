//! Vertices moved by morph targets and skins, on the CPU in double precision.

use super::file::{File, find};
use super::pose::{Pose, affine};
use glam::{DAffine3, DVec3, Vec3};

/// The joints of a skin.
pub(super) struct Skin {
    number: usize,
    /// Node of each joint.
    pub(super) joints: Vec<usize>,
    /// Mesh space in the bind pose to each joint's space.
    binds: Vec<DAffine3>,
}

impl Skin {
    pub(super) fn read(file: &File, number: usize) -> Result<Self, String> {
        let skin = find(&file.root.skins, number, "skin")?;
        let joints: Vec<usize> = skin.joints.iter().map(|j| j.value()).collect();
        let binds = match skin.inverse_bind_matrices {
            Some(accessor) => file.floats::<16>(accessor, "inverseBindMatrices")?.iter().map(affine).collect(),
            None => vec![DAffine3::IDENTITY; joints.len()],
        };
        if binds.len() < joints.len() {
            let (joints, binds) = (joints.len(), binds.len());
            return Err(format!("skin {number} has {joints} joints but {binds} inverse bind matrices"));
        }
        Ok(Self { number, joints, binds })
    }

    /// Joint matrices: mesh space in the bind pose to world space.
    fn matrices(&self, pose: &Pose) -> Result<Vec<DAffine3>, String> {
        let joint = |(i, (joint, bind)): (usize, (&usize, &DAffine3))| {
            let matrix = *find(&pose.worlds, *joint, "node")? * *bind;
            let finite = matrix.is_finite().then_some(matrix);
            finite.ok_or_else(|| format!("joint {i} of skin {} has a matrix that is not finite", self.number))
        };
        self.joints.iter().zip(&self.binds).enumerate().map(joint).collect()
    }
}

/// The vertices of a primitive before anything moves them, and what can.
#[derive(Clone)]
pub(super) struct Rest {
    /// Mesh space.
    pub(super) positions: Vec<[f32; 3]>,
    /// Position deltas of each morph target; empty where a target moves nothing.
    pub(super) targets: Vec<Vec<[f32; 3]>>,
    pub(super) binding: Option<Binding>,
}

impl Rest {
    /// Whether any morph target moves a vertex.
    pub(super) fn has_targets(&self) -> bool {
        self.targets.iter().any(|t| !t.is_empty())
    }

    /// Keeps the vertices named, in this order.
    pub(super) fn pick(&mut self, order: &[u32]) {
        fn pick<T: Copy>(list: &mut Vec<T>, order: &[u32]) {
            *list = order.iter().map(|&i| list[i as usize]).collect();
        }
        pick(&mut self.positions, order);
        self.targets.iter_mut().filter(|t| !t.is_empty()).for_each(|t| pick(t, order));
        if let Some(binding) = &mut self.binding {
            binding.joints.iter_mut().for_each(|set| pick(set, order));
            binding.weights.iter_mut().for_each(|set| pick(set, order));
        }
    }

    /// World positions as `node` shows them: by the skin's joints where there is one, else by the node's matrix.
    pub(super) fn place(
        &self,
        pose: &Pose,
        node: usize,
        weights: &[f64],
        skin: Option<&Skin>,
    ) -> Result<Vec<DVec3>, String> {
        let mut positions: Vec<DVec3> = self.positions.iter().map(|p| Vec3::from(*p).as_dvec3()).collect();
        morph(&mut positions, &self.targets, weights);
        match (skin, &self.binding) {
            (Some(skin), Some(binding)) => binding.apply(&mut positions, &skin.matrices(pose)?)?,
            _ => positions.iter_mut().for_each(|p| *p = pose.worlds[node].transform_point3(*p)),
        }
        match positions.iter().position(|p| !p.is_finite()) {
            Some(vertex) => Err(format!("vertex {vertex} is posed at {}; it must be finite", positions[vertex])),
            None => Ok(positions),
        }
    }
}

/// A primitive that an animation deforms, as one node shows it.
pub(super) struct Deform {
    pub(super) rest: Rest,
    pub(super) node: usize,
    /// Morph weights where neither the node nor its animation gives any.
    pub(super) weights: Vec<f64>,
    pub(super) skin: Option<Skin>,
}

impl Deform {
    /// World positions in a pose of the file it was made from.
    pub(super) fn place(&self, pose: &Pose) -> Result<Vec<DVec3>, String> {
        let weights = pose.weights[self.node].as_ref().unwrap_or(&self.weights);
        let placed = self.rest.place(pose, self.node, weights, self.skin.as_ref());
        placed.map_err(|e| format!("node {}: {e}", self.node))
    }
}

/// What a vertex is bound to: joints and weights, four for each attribute set.
#[derive(Clone)]
pub(super) struct Binding {
    /// Joint numbers of each vertex, by attribute set.
    pub(super) joints: Vec<Vec<[u32; 4]>>,
    /// Weights, parallel to `joints`.
    pub(super) weights: Vec<Vec<[f32; 4]>>,
}

impl Binding {
    /// Moves vertices from the bind pose to world space. Weights are normalised; a vertex without weights follows
    /// its first joint.
    fn apply(&self, positions: &mut [DVec3], joints: &[DAffine3]) -> Result<(), String> {
        for (vertex, position) in positions.iter_mut().enumerate() {
            let mut sum = DVec3::ZERO;
            let mut total = 0.0;
            let mut fallback = None;
            for (sets, weights) in self.joints.iter().zip(&self.weights) {
                for (joint, weight) in sets[vertex].iter().zip(weights[vertex]) {
                    let weight = f64::from(weight);
                    fallback = fallback.or(Some(*joint));
                    // joints of zero weight may be out of range in valid files
                    if weight.is_finite() && weight > 0.0 {
                        sum += weight * find_joint(joints, *joint, vertex)?.transform_point3(*position);
                        total += weight;
                    }
                }
            }
            *position = match fallback {
                _ if total > 0.0 => sum / total,
                Some(joint) => find_joint(joints, joint, vertex)?.transform_point3(*position),
                None => *position,
            };
        }
        Ok(())
    }
}

fn find_joint(joints: &[DAffine3], joint: u32, vertex: usize) -> Result<&DAffine3, String> {
    let count = joints.len();
    joints.get(joint as usize).ok_or_else(|| format!("vertex {vertex} names joint {joint} but the skin has {count}"))
}

/// Adds the morph targets' position deltas; targets and weights beyond each other's number have no effect.
fn morph(positions: &mut [DVec3], targets: &[Vec<[f32; 3]>], weights: &[f64]) {
    for (target, weight) in targets.iter().zip(weights).filter(|(_, w)| **w != 0.0) {
        for (position, delta) in positions.iter_mut().zip(target) {
            *position += *weight * Vec3::from(*delta).as_dvec3();
        }
    }
}
