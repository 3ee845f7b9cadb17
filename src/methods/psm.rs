//! Perspective shadow maps (Stamminger, Drettakis 2002; book, 4.2.1), in the form in which they compare with the other warps
//! (book, p. 100): the warp's line passes through the eye, as the view's own projection has it. The light stays parallel,
//! so that nothing wraps through infinity, and casters behind the eye are not lost.

use super::warp::{RESOLUTION, Rule, Settings, WARP, settings};
use super::{MethodInfo, MethodSpec, Parameter};
use crate::lab::LabError;

const PARAMETERS: &[Parameter] =
    &[RESOLUTION, WARP, super::BIAS, super::DEPTH_BIAS, super::CULL, super::FILTER[0], super::FILTER[1]];

pub(super) const INFO: MethodInfo = MethodInfo {
    name: "psm",
    source: "Stamminger, Drettakis 2002; Eisemann et al. 2011, 4.2.1",
    summary: "One map, warped as the view's own perspective does: texels across are even, those along are not",
    parameters: PARAMETERS,
};

pub(super) fn parse(spec: &MethodSpec) -> Result<Settings, LabError> {
    spec.known(PARAMETERS)?;
    settings(spec, Rule::Eye)
}
