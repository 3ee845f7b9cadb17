//! Perspective shadow maps (Stamminger, Drettakis 2002; book, 4.2.1), in the form in which they compare with the other warps
//! (book, p. 100): the warp's line passes through the eye, as the view's own projection has it. The light stays parallel,
//! so that nothing wraps through infinity, and casters behind the eye are not lost.

use super::comparison::Comparison;
use super::warp::{RESOLUTION, Settings, WARP, Warp, settings};
use super::warp_passes::Rule;
use super::{MethodInfo, MethodSpec, Parameter};
use crate::lab::LabError;

const PARAMETERS: [Parameter; 7] = Comparison::keys(&[RESOLUTION, WARP]);

pub(super) const INFO: MethodInfo = MethodInfo {
    name: "psm",
    source: "Stamminger, Drettakis 2002; Eisemann et al. 2011, 4.2.1",
    summary: "One map, warped as the view's own perspective does: texels across are even, those along are not",
    parameters: &PARAMETERS,
    check: |spec| parse(spec).map(|_| ()),
    create: |spec, lab| Ok(Box::new(Warp::new(INFO.name, spec, lab, parse(spec)?)?)),
};

fn parse(spec: &MethodSpec) -> Result<Settings, LabError> {
    settings(spec, Rule::Eye)
}
