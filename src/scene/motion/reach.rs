//! How far moving parts get: world bounds that hold at all times.

use super::How;
use crate::scene::assemble::{Bounds, EMPTY, EXACT_VERTICES, Part, bounds, corners, union};
use crate::scene::pose::{Pose, Rig};
use glam::DVec3;
use rayon::prelude::*;

/// Times at which an animation is sampled at least, evenly spread.
const SAMPLES: u32 = 128;
/// Most key times that are sampled besides; of more, every n-th.
const KEYS: u64 = 1024;
/// Share of a part's bounds by which they grow on each side, for what lies between the samples.
const SLACK: f64 = 0.03;

/// Sets the bounds of every part that moves.
pub(in crate::scene) fn reach(rig: &Rig, parts: &mut [Part], time_s: f64) -> Result<(), String> {
    if parts.iter().all(|part| part.moves.is_none()) {
        return Ok(());
    }
    let deforms = |p: &&Part| p.moves.is_some() && p.instances.is_empty();
    let deforming: u64 = parts.iter().filter(deforms).map(|p| p.positions.len() as u64).sum();
    let poses = times(rig, deforming).into_par_iter().chain([time_s]).map(|time| rig.pose(time));
    let poses: Vec<Pose> = poses.collect::<Result<_, _>>()?;
    for part in parts {
        let Some(moves) = &part.moves else { continue };
        let boxes = match &moves.how {
            How::Deforms(deform) => poses
                .par_iter()
                .map(|pose| deform.place(pose).map(|placed| vec![bounds(placed.into_iter())]))
                .try_reduce(Vec::new, |a, b| Ok(unions(a, b)))?,
            How::Rigid { nodes, .. } => {
                let work = part.positions.len() as u64 * nodes.len() as u64 * poses.len() as u64;
                let corners = if work > EXACT_VERTICES { corners(part) } else { Vec::new() };
                let points = if corners.is_empty() { &part.positions } else { &corners };
                let at =
                    |pose: &Pose, node: usize| bounds(points.iter().map(|p| pose.worlds[node].transform_point3(*p)));
                let of = |pose| nodes.iter().map(|(_, node)| at(pose, *node)).collect();
                poses.par_iter().map(of).reduce(Vec::new, unions)
            }
        };
        let mut still = vec![true; part.instances.len()];
        if let How::Rigid { nodes, .. } = &moves.how {
            nodes.iter().for_each(|(i, _)| still[*i as usize] = false);
        }
        let still = part.instances.iter().zip(still).filter(|(_, still)| *still);
        let still = bounds(still.flat_map(|(m, _)| part.positions.iter().map(|p| m.transform_point3(*p))));
        let all = boxes.into_iter().map(widen).fold(still, union);
        if let Some(moves) = &mut part.moves {
            moves.bounds = all;
        }
    }
    Ok(())
}

/// Box by box; an empty list is neutral.
fn unions(a: Vec<Bounds>, b: Vec<Bounds>) -> Vec<Bounds> {
    let long = a.len().max(b.len());
    let at = |list: &[Bounds], i: usize| list.get(i).copied().unwrap_or(EMPTY);
    (0..long).map(|i| union(at(&a, i), at(&b, i))).collect()
}

fn widen((low, high): Bounds) -> Bounds {
    let slack = DVec3::splat(SLACK * (high - low).max_element());
    (low - slack, high + slack)
}

/// Evenly spread times and key times; fewer of the latter where many vertices deform.
fn times(rig: &Rig, deforming: u64) -> Vec<f64> {
    let even = (0..SAMPLES).map(|i| rig.duration * f64::from(i) / f64::from(SAMPLES - 1));
    let keys = rig.key_times();
    let most = (EXACT_VERTICES / deforming.max(1)).clamp(u64::from(SAMPLES), KEYS) as usize;
    let step = keys.len().div_ceil(most).max(1);
    even.chain(keys.into_iter().step_by(step)).collect()
}
