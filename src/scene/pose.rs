//! The pose of a file at one time: the transforms of its nodes and their morph weights.
//!
//! A file with animations is shown as a viewer would: the first animation plays and is sampled at the given time,
//! also at time 0. Times outside 0 to the animation's duration wrap around. Files without animations stand as stored.

use super::file::File;
use super::nodes::Tree;
use super::track::Track;
use ::gltf::json::animation::Property;
use glam::{DAffine3, DMat3, DQuat, DVec3, DVec4};

/// All that poses depend on but the time; needs the file no more.
pub(super) struct Rig {
    /// All nodes, parents first.
    order: Vec<usize>,
    parent: Vec<Option<usize>>,
    /// Nodes as stored.
    locals: Vec<Local>,
    /// The first animation's nodes and tracks.
    channels: Vec<(usize, Track)>,
    /// Length of the animation in seconds.
    pub(super) duration: f64,
}

impl Rig {
    /// Reads the nodes and the first animation.
    pub(super) fn new(file: &File, tree: &Tree) -> Result<Self, String> {
        let locals: Vec<Local> = file.root.nodes.iter().map(Local::new).collect();
        let count = locals.len();
        let animation = file.root.animations.first();
        let channels = animation.iter().flat_map(|a| a.channels.iter().map(move |c| (a, c))).enumerate();
        let channels = channels.map(|(i, (animation, channel))| {
            let track = Track::new(file, animation, channel).map_err(|e| format!("animation 0, channel {i}: {e}"))?;
            match channel.target.node.value() {
                node if node < count => Ok((node, track)),
                node => Err(format!("animation 0 moves node {node} but the file has {count}")),
            }
        });
        let channels: Vec<(usize, Track)> = channels.collect::<Result<_, String>>()?;
        let duration = channels.iter().filter_map(|(_, t)| t.times.last()).fold(0.0f64, |a, b| a.max(f64::from(*b)));
        Ok(Self { order: tree.order.clone(), parent: tree.parent.clone(), locals, channels, duration })
    }

    /// Poses all nodes; every transform is finite afterwards.
    pub(super) fn pose(&self, time_s: f64) -> Result<Pose, String> {
        if !time_s.is_finite() {
            return Err(format!("the time is {time_s} s; it must be finite"));
        }
        let inside = (0.0..=self.duration).contains(&time_s);
        let time = if inside { time_s } else { time_s.rem_euclid(self.duration.max(1e-9)) };
        let mut locals = self.locals.clone();
        for (node, track) in &self.channels {
            locals[*node].set(track.property, &track.sample(time));
        }
        let mut worlds = vec![DAffine3::IDENTITY; locals.len()];
        for &i in &self.order {
            let above = self.parent[i].map_or(DAffine3::IDENTITY, |p| worlds[p]);
            worlds[i] = above * locals[i].matrix();
            if !worlds[i].is_finite() {
                return Err(format!("node {i} has a transform that is not finite"));
            }
        }
        Ok(Pose { worlds, weights: locals.into_iter().map(|l| l.weights).collect() })
    }

    /// For each node whether the animation moves it or a node above it.
    pub(super) fn moving(&self) -> Vec<bool> {
        let mut moving = vec![false; self.locals.len()];
        let moves = |(_, track): &&(usize, Track)| track.property != Property::MorphTargetWeights;
        self.channels.iter().filter(moves).for_each(|(node, _)| moving[*node] = true);
        for &i in &self.order {
            moving[i] |= self.parent[i].is_some_and(|p| moving[p]);
        }
        moving
    }

    /// Whether the animation changes the node's morph weights.
    pub(super) fn morphs(&self, node: usize) -> bool {
        self.channels.iter().any(|(n, track)| *n == node && track.property == Property::MorphTargetWeights)
    }

    /// All key times in seconds, ascending, each once.
    pub(super) fn key_times(&self) -> Vec<f64> {
        let mut times: Vec<f64> = self.channels.iter().flat_map(|(_, t)| &t.times).map(|t| f64::from(*t)).collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        times
    }
}

/// World transforms and morph weights of all nodes.
pub(super) struct Pose {
    /// World matrix of each node.
    pub(super) worlds: Vec<DAffine3>,
    /// Morph weights of each node, where the node or its animation gives any.
    pub(super) weights: Vec<Option<Vec<f64>>>,
}

/// Transform of a node relative to its parent, before it is one matrix.
#[derive(Clone)]
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
pub(super) fn unit(q: DVec4) -> DQuat {
    DQuat::from_vec4(q.try_normalize().unwrap_or(DVec4::W))
}

/// The upper three rows of a column-major matrix.
pub(super) fn affine(m: &[f32; 16]) -> DAffine3 {
    let column = |i: usize| DVec3::new(m[4 * i].into(), m[4 * i + 1].into(), m[4 * i + 2].into());
    DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) }
}
