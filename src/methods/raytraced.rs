//! The reference: one ray a pixel on all CPU cores, alpha honoured.

use super::{FrameTimes, Method, MethodInfo, MethodSpec, Statistics};
use crate::lab::{Lab, LabError};
use std::time::Instant;

pub(super) const INFO: MethodInfo = MethodInfo {
    name: "raytraced",
    source: "Appel 1968; the reference of all error figures",
    summary: "One ray from every visible sample to the light through a BVH, on the CPU",
    parameters: &[],
};

pub(super) struct Raytraced {
    visibility: Vec<f32>,
    bytes: u64,
}

impl Raytraced {
    pub(super) fn new(spec: &MethodSpec, lab: &Lab) -> Result<Self, LabError> {
        super::hard_directional(spec, lab)?;
        Ok(Self { visibility: Vec::new(), bytes: lab.tracer().bytes() })
    }
}

impl Method for Raytraced {
    fn frame(&mut self, lab: &Lab) -> Result<FrameTimes, LabError> {
        let gbuffer = lab.gbuffer()?;
        let start = Instant::now();
        let visibility = crate::truth::trace_visibility(lab.tracer(), lab.scene(), &gbuffer, &lab.view().lights[0]);
        let ms = start.elapsed().as_secs_f64() * 1e3;
        self.visibility = visibility.map_err(|error| LabError::Refused(error.to_string()))?;
        Ok(FrameTimes { prepass_ms: 0.0, ms, wall_ms: ms, stages: vec![("trace", ms)] })
    }

    fn visibility(&mut self, _lab: &Lab) -> Result<Vec<f32>, LabError> {
        Ok(self.visibility.clone())
    }

    fn memory(&self) -> Vec<(&'static str, u64)> {
        vec![("bvh", self.bytes)]
    }

    fn statistics(&mut self, _lab: &Lab) -> Result<Statistics, LabError> {
        Ok(Statistics::default())
    }
}
