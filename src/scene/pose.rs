//! The pose of a file at one time: node transforms, skins and morph targets, all on the CPU.
//!
//! A file with animations is shown as a viewer would: the first animation plays and is sampled at the given time,
//! also at time 0. Times outside 0 to the animation's duration wrap around. Files without animations stand as stored.

use super::file::{File, find};
use super::nodes::Tree;
use ::gltf::json::accessor::Accessor;
use ::gltf::json::animation::{Animation, Channel, Interpolation, Property};
use ::gltf::json::{Index, validation::Checked};
use glam::{DAffine3, DMat3, DQuat, DVec3, DVec4};

/// World transforms and morph weights of all nodes.
pub(super) struct Pose {
    /// World matrix of each node.
    pub(super) worlds: Vec<DAffine3>,
    /// Morph weights of each node, where the node or its animation gives any.
    weights: Vec<Option<Vec<f64>>>,
}

impl Pose {
    /// Poses all nodes; every transform is finite afterwards.
    pub(super) fn new(file: &File, tree: &Tree, time_s: f64) -> Result<Self, String> {
        if !time_s.is_finite() {
            return Err(format!("the time is {time_s} s; it must be finite"));
        }
        let mut locals: Vec<Local> = file.root.nodes.iter().map(Local::new).collect();
        if let Some(animation) = file.root.animations.first() {
            animate(file, animation, time_s, &mut locals)?;
        }
        let mut worlds = vec![DAffine3::IDENTITY; locals.len()];
        for &i in &tree.order {
            let above = tree.parent[i].map_or(DAffine3::IDENTITY, |p| worlds[p]);
            worlds[i] = above * locals[i].matrix();
            if !worlds[i].is_finite() {
                return Err(format!("node {i} has a transform that is not finite"));
            }
        }
        Ok(Self { worlds, weights: locals.into_iter().map(|l| l.weights).collect() })
    }

    /// Weights of the mesh's morph targets as this node shows it.
    pub(super) fn weights(&self, file: &File, node: usize, mesh: usize) -> Vec<f64> {
        match &self.weights[node] {
            Some(weights) => weights.clone(),
            None => file.root.meshes[mesh].weights.iter().flatten().map(|w| f64::from(*w)).collect(),
        }
    }

    /// Joint matrices of a skin: mesh space in the bind pose to world space.
    pub(super) fn joints(&self, file: &File, skin: usize) -> Result<Vec<DAffine3>, String> {
        let joints = &find(&file.root.skins, skin, "skin")?.joints;
        let binds = match file.root.skins[skin].inverse_bind_matrices {
            Some(accessor) => file.floats::<16>(accessor, "inverseBindMatrices")?,
            None => vec![glam::Mat4::IDENTITY.to_cols_array(); joints.len()],
        };
        if binds.len() < joints.len() {
            return Err(format!("skin {skin} has {} joints but {} inverse bind matrices", joints.len(), binds.len()));
        }
        let joint = |(i, bind): (usize, &[f32; 16])| {
            let matrix = *find(&self.worlds, joints[i].value(), "node")? * affine(bind);
            let finite = matrix.is_finite().then_some(matrix);
            finite.ok_or_else(|| format!("joint {i} of skin {skin} has a matrix that is not finite"))
        };
        binds.iter().take(joints.len()).enumerate().map(joint).collect()
    }
}

/// Transform of a node relative to its parent, before it is one matrix.
struct Local {
    matrix: Option<[f32; 16]>,
    translation: DVec3,
    rotation: DQuat,
    scale: DVec3,
    weights: Option<Vec<f64>>,
}

impl Local {
    fn new(node: &::gltf::json::Node) -> Self {
        let vector = |v: Option<[f32; 3]>, or: DVec3| v.map_or(or, |v| glam::Vec3::from(v).as_dvec3());
        Self {
            matrix: node.matrix,
            translation: vector(node.translation, DVec3::ZERO),
            rotation: unit(node.rotation.map_or(DVec4::W, |q| glam::Vec4::from(q.0).as_dvec4())),
            scale: vector(node.scale, DVec3::ONE),
            weights: node.weights.as_ref().map(|w| w.iter().map(|w| f64::from(*w)).collect()),
        }
    }

    fn matrix(&self) -> DAffine3 {
        match &self.matrix {
            Some(matrix) => affine(matrix),
            None => DAffine3::from_scale_rotation_translation(self.scale, self.rotation, self.translation),
        }
    }

    fn set(&mut self, property: Property, value: &[f64]) {
        let vector = || DVec3::new(value[0], value[1], value[2]);
        // a node with a matrix must not be animated; where one is, its keys win
        if property != Property::MorphTargetWeights {
            self.matrix = None;
        }
        match property {
            Property::Translation => self.translation = vector(),
            Property::Rotation => self.rotation = unit(DVec4::from_slice(value)),
            Property::Scale => self.scale = vector(),
            Property::MorphTargetWeights => self.weights = Some(value.to_vec()),
        }
    }
}

/// The unit quaternion along `q`; the identity where there is no direction.
fn unit(q: DVec4) -> DQuat {
    DQuat::from_vec4(q.try_normalize().unwrap_or(DVec4::W))
}

/// The upper three rows of a column-major matrix.
fn affine(m: &[f32; 16]) -> DAffine3 {
    let column = |i: usize| DVec3::new(m[4 * i].into(), m[4 * i + 1].into(), m[4 * i + 2].into());
    DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) }
}

fn animate(file: &File, animation: &Animation, time_s: f64, locals: &mut [Local]) -> Result<(), String> {
    let channels = animation.channels.iter().enumerate().map(|(i, channel)| {
        let track = Track::new(file, animation, channel).map_err(|e| format!("animation 0, channel {i}: {e}"))?;
        Ok((channel.target.node.value(), track))
    });
    let channels: Vec<(usize, Track)> = channels.collect::<Result<_, String>>()?;
    let duration = channels.iter().filter_map(|(_, t)| t.times.last()).fold(0.0f64, |a, b| a.max(f64::from(*b)));
    let time = if (0.0..=duration).contains(&time_s) { time_s } else { time_s.rem_euclid(duration.max(1e-9)) };
    for (node, track) in &channels {
        let count = locals.len();
        let local =
            locals.get_mut(*node).ok_or_else(|| format!("animation 0 moves node {node} but the file has {count}"))?;
        local.set(track.property, &track.sample(time));
    }
    Ok(())
}

/// The keys of one channel.
struct Track {
    property: Property,
    interpolation: Interpolation,
    times: Vec<f32>,
    /// Numbers in one value.
    width: usize,
    /// One value a key; three for cubic splines: in-tangent, value, out-tangent.
    values: Vec<f32>,
}

impl Track {
    fn new(file: &File, animation: &Animation, channel: &Channel) -> Result<Self, String> {
        let sampler = find(&animation.samplers, channel.sampler.value(), "sampler")?;
        let (Checked::Valid(property), Checked::Valid(interpolation)) = (channel.target.path, sampler.interpolation)
        else {
            return Err("the target path or the interpolation is unknown".to_string());
        };
        let times: Vec<f32> = file.floats::<1>(sampler.input, "key times")?.into_iter().flatten().collect();
        if times.is_empty() || times.iter().any(|t| !t.is_finite()) {
            return Err(format!("{} key times, some not finite; at least one finite key is needed", times.len()));
        }
        let values = read_values(file, property, sampler.output)?;
        let slots = times.len() * if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        let width = match property {
            Property::Translation | Property::Scale => 3,
            Property::Rotation => 4,
            Property::MorphTargetWeights => values.len() / slots,
        };
        if values.len() != width * slots {
            return Err(format!("{} numbers for {} keys; {} are needed", values.len(), times.len(), width * slots));
        }
        Ok(Self { property, interpolation, times, width, values })
    }

    fn slot(&self, slot: usize) -> Vec<f64> {
        self.values[slot * self.width..][..self.width].iter().map(|v| f64::from(*v)).collect()
    }

    /// The value at a key, without tangents.
    fn key(&self, key: usize) -> Vec<f64> {
        self.slot(if self.interpolation == Interpolation::CubicSpline { 3 * key + 1 } else { key })
    }

    /// The value at a time; the first and the last key hold outside their range.
    fn sample(&self, time: f64) -> Vec<f64> {
        let next = self.times.partition_point(|t| f64::from(*t) <= time);
        if next == 0 || next == self.times.len() {
            return self.key(next.saturating_sub(1));
        }
        let from = f64::from(self.times[next - 1]);
        let span = f64::from(self.times[next]) - from;
        let part = ((time - from) / span).clamp(0.0, 1.0);
        let (a, b) = (self.key(next - 1), self.key(next));
        match self.interpolation {
            Interpolation::Step => a,
            Interpolation::Linear if self.property == Property::Rotation => {
                let (a, b) = (unit(DVec4::from_slice(&a)), unit(DVec4::from_slice(&b)));
                a.slerp(b, part).to_array().to_vec()
            }
            Interpolation::Linear => a.iter().zip(&b).map(|(a, b)| a + (b - a) * part).collect(),
            Interpolation::CubicSpline => {
                let (out, into) = (self.slot(3 * (next - 1) + 2), self.slot(3 * next));
                (0..self.width).map(|c| hermite(part, span, [a[c], out[c], into[c], b[c]])).collect()
            }
        }
    }
}

/// Cubic Hermite spline of glTF 2.0, appendix C.4, on value, out-tangent, in-tangent, value.
fn hermite(t: f64, span: f64, [a, out, into, b]: [f64; 4]) -> f64 {
    let (t2, t3) = (t * t, t * t * t);
    (2.0 * t3 - 3.0 * t2 + 1.0) * a
        + span * (t3 - 2.0 * t2 + t) * out
        + (-2.0 * t3 + 3.0 * t2) * b
        + span * (t3 - t2) * into
}

fn read_values(file: &File, property: Property, output: Index<Accessor>) -> Result<Vec<f32>, String> {
    let what = "key values";
    let values: Vec<f32> = match property {
        Property::Translation | Property::Scale => file.floats::<3>(output, what)?.into_flattened(),
        Property::Rotation => file.floats::<4>(output, what)?.into_flattened(),
        Property::MorphTargetWeights => file.floats::<1>(output, what)?.into_flattened(),
    };
    match values.iter().position(|v| !v.is_finite()) {
        Some(i) => Err(format!("key value {i} is {}; it must be finite", values[i])),
        None => Ok(values),
    }
}

/// What a vertex is bound to: joints and weights, four for each attribute set.
pub(super) struct Binding {
    /// Joint numbers of each vertex, by attribute set.
    pub(super) joints: Vec<Vec<[u32; 4]>>,
    /// Weights, parallel to `joints`.
    pub(super) weights: Vec<Vec<[f32; 4]>>,
}

impl Binding {
    /// Moves vertices from the bind pose to world space. Weights are normalised; a vertex without weights follows
    /// its first joint.
    pub(super) fn apply(&self, positions: &mut [DVec3], joints: &[DAffine3]) -> Result<(), String> {
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
pub(super) fn morph(positions: &mut [DVec3], targets: &[Vec<[f32; 3]>], weights: &[f64]) {
    for (target, weight) in targets.iter().zip(weights).filter(|(_, w)| **w != 0.0) {
        for (position, delta) in positions.iter_mut().zip(target) {
            *position += *weight * glam::Vec3::from(*delta).as_dvec3();
        }
    }
}
