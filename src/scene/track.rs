//! One property of one node over time: the keys of an animation's channel and what lies between them.

use super::file::{File, find};
use super::pose::unit;
use ::gltf::json::accessor::Accessor;
use ::gltf::json::animation::{Animation, Channel, Interpolation, Property};
use ::gltf::json::{Index, validation::Checked};
use glam::DVec4;

/// The keys of one channel.
pub(super) struct Track {
    pub(super) property: Property,
    interpolation: Interpolation,
    /// Seconds, ascending.
    pub(super) times: Vec<f32>,
    /// Numbers in one value.
    width: usize,
    /// One value a key; three for cubic splines: in-tangent, value, out-tangent.
    values: Vec<f32>,
}

impl Track {
    pub(super) fn new(file: &File, animation: &Animation, channel: &Channel) -> Result<Self, String> {
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
    pub(super) fn sample(&self, time: f64) -> Vec<f64> {
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
