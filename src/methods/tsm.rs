//! Trapezoidal shadow maps (Martin, Tan 2004; book, 4.2.1): the same family of warps, with the parameter chosen so that the
//! nearest part of what is seen gets four fifths of the map.

use super::comparison::Comparison;
use super::warp::{RESOLUTION, Settings, WARP, Warp, settings};
use super::warp_passes::Rule;
use super::{MethodInfo, MethodSpec, Parameter};
use crate::lab::LabError;

const PARAMETERS: [Parameter; 8] = Comparison::keys(&[
    RESOLUTION,
    Parameter {
        key: "focus",
        default: "0.3",
        allowed: "0.01 to 0.79",
        meaning: "share of the samples' extent along the view that gets four fifths of the map",
    },
    WARP,
]);

pub(super) const INFO: MethodInfo = MethodInfo {
    name: "tsm",
    source: "Martin, Tan 2004; Eisemann et al. 2011, 4.2.1",
    summary: "One map, warped so that a focus region gets four fifths of it",
    parameters: &PARAMETERS,
    check: |spec| parse(spec).map(|_| ()),
    create: |spec, lab| Ok(Box::new(Warp::new(INFO.name, spec, lab, parse(spec)?)?)),
};

fn parse(spec: &MethodSpec) -> Result<Settings, LabError> {
    settings(spec, Rule::Focus(spec.f32_in("focus", 0.3, 0.01..=0.79)?))
}
