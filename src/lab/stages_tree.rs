//! The tree of tiles that methods refine, with requests given by tests, and what a frame of such a method left: what tests compare
//! with plain algorithms.

use super::stages::write;
use super::{Lab, LabError};
use crate::gpu::structs::{Region, TreeMeasurePush, TreeState};
use crate::gpu::sync::{self, Access::*};
use crate::methods::fvsm::Fvsm;
use crate::methods::qvsm::Qvsm;
use crate::methods::tiled::Tiled;
use crate::methods::tree::Tree;
use crate::methods::{Method, MethodSpec};

pub use crate::methods::tree::{Rule, TreeFrame, TreeShape};

type Result<T> = std::result::Result<T, LabError>;

/// The root is refined by given requests.
pub struct TreeStage(Tree);

impl TreeStage {
    /// Without requests.
    pub fn new(lab: &Lab, shape: TreeShape) -> Result<Self> {
        Ok(Self(Tree::new(&lab.gpu, shape)?))
    }

    /// Refines the root by `requests` in so many rounds, and measures what comes out. `drop`: share of a region's samples whose
    /// requests do not count. By [`Rule::Changed`] every region with samples is split.
    pub fn refine(&self, lab: &Lab, requests: &[u32], drop: f32, rounds: u32) -> Result<(Vec<Region>, TreeState)> {
        let device = &lab.gpu.device;
        lab.submit(|cmd| {
            self.0.reset(cmd);
            sync::barrier(device, cmd, &[(TransferWrite, TransferWrite), (TransferWrite, ComputeWrite)]);
        })?;
        write(lab, &self.0.requests, requests)?;
        lab.submit(|cmd| {
            for round in 0..=rounds {
                self.0.measure(cmd, TreeMeasurePush { round, drop, threshold: 0, start: rounds });
                if round < rounds {
                    self.0.expand(cmd, round);
                }
            }
        })?;
        self.0.read(lab, rounds)
    }
}

/// What a frame of `fvsm` left, for a directional light.
pub fn fvsm(lab: &Lab, spec: &str) -> Result<TreeFrame> {
    let mut method = Fvsm::new(&parsed(spec)?, lab)?;
    method.frame(lab)?;
    method.left(lab)
}

/// What a frame of `qvsm` left, and the round that the visibility of each pixel is of.
pub fn qvsm(lab: &Lab, spec: &str) -> Result<(TreeFrame, Vec<u32>)> {
    let mut method = Qvsm::new(&parsed(spec)?, lab)?;
    method.frame(lab)?;
    Ok((method.left(lab)?, method.served(lab)?))
}

/// What a frame of `tiled` left; the importance of entries in place of requests.
pub fn tiled(lab: &Lab, spec: &str) -> Result<TreeFrame> {
    let mut method = Tiled::new(&parsed(spec)?, lab)?;
    method.frame(lab)?;
    method.left(lab)
}

fn parsed(spec: &str) -> Result<MethodSpec> {
    let spec = MethodSpec::parse(spec).map_err(LabError::Usage)?;
    crate::methods::check(&spec)?;
    Ok(spec)
}
