//! The warp of [`crate::methods`]' `rtw` from importance given by tests, and the importance that it finds itself.

use super::stages::{read, write};
use super::{Lab, LabError};
use crate::engine::constants::light_axes;
use crate::gpu::structs::Fit;
use crate::gpu::sync::{self, Access::*};
use crate::methods::rtw::{Rtw, WarpMaps};
use crate::methods::{Method, MethodSpec, check};
use crate::twin::rtw::Axis;
use glam::DVec3;

type Result<T> = std::result::Result<T, LabError>;

/// What makes a warp of importance.
pub struct WarpStage {
    maps: WarpMaps,
    cells: usize,
    side: usize,
}

impl WarpStage {
    /// `cells`: along a side of the importance map; `side`: of the map, in texels; `blur`: in cells.
    pub fn new(lab: &Lab, cells: u32, side: u32, blur: f32) -> Result<Self> {
        Ok(Self { maps: WarpMaps::new(lab.gpu(), cells, side, blur)?, cells: cells as usize, side: side as usize })
    }

    /// The warps along u and along v.
    pub fn run(&self, lab: &Lab, importance: &[f32]) -> Result<[Axis; 2]> {
        lab.submit(|cmd| {
            sync::barrier(&lab.gpu().device, cmd, &[(ComputeWrite, TransferWrite), (TransferRead, TransferWrite)]);
            self.maps.clear(lab.gpu(), cmd);
            sync::barrier(&lab.gpu().device, cmd, &[(TransferWrite, TransferWrite), (TransferWrite, ComputeWrite)]);
        })?;
        write(lab, self.maps.importance_buffer(), importance)?;
        lab.submit(|cmd| {
            self.maps.record(lab.gpu(), cmd);
            sync::barrier(&lab.gpu().device, cmd, &[(ComputeWrite, TransferRead)]);
        })?;
        let centres: Vec<[f32; 2]> = read(lab, self.maps.centres())?;
        let mut centres = centres[..2 * self.side].chunks(self.side).map(<[_]>::to_vec);
        Ok(self.maps.warp(lab)?.map(|warp| Axis { warp, centres: centres.next().unwrap_or_default() }))
    }

    /// Cells along a side of the importance map.
    pub fn cells(&self) -> usize {
        self.cells
    }
}

/// The importance map of a frame of `rtw`, row by row, and what it covers.
pub fn importance(lab: &Lab, spec: &MethodSpec) -> Result<(Vec<f32>, Fit)> {
    check(spec)?;
    let mut rtw = Rtw::new(spec, lab)?;
    rtw.frame(lab)?;
    rtw.importance(lab)
}

/// The directions across a parallel light that fits are in, and its own.
pub fn across(direction: DVec3) -> Result<[DVec3; 3]> {
    Ok(light_axes(direction)?)
}
