//! Logarithmic perspective shadow maps (Lloyd et al. 2008; book, 4.2.4): a perspective warp, which makes texels across the view as
//! large as pixels, then a logarithm along it, which does the same there. Edges are bent, so that every texel asks triangles itself.

use super::comparison::Comparison;
use super::warp::{RESOLUTION, Settings, WARP, Warp, logarithmic};
use super::warp_passes::Rule;
use super::{MethodInfo, MethodSpec, Parameter};
use crate::lab::LabError;

const PARAMETERS: [Parameter; 8] = Comparison::keys(&[
    RESOLUTION,
    Parameter {
        key: "line",
        default: "depth",
        allowed: "depth, eye or even",
        meaning: "where the warp's line lies: where depth falls to 0 if it grows evenly over the samples' extent, through the eye, or as lispsm's",
    },
    WARP,
]);

pub(super) const INFO: MethodInfo = MethodInfo {
    name: "logpsm",
    source: "Lloyd, Govindaraju, Quammen, Molnar, Manocha 2008; Eisemann et al. 2011, 4.2.4",
    summary: "One map, warped and then logarithmic along the view: texels grow as pixels do, both across and along",
    parameters: &PARAMETERS,
    check: |spec| parse(spec).map(|_| ()),
    create: |spec, lab| Ok(Box::new(Warp::new(INFO.name, spec, lab, parse(spec)?)?)),
};

fn parse(spec: &MethodSpec) -> Result<Settings, LabError> {
    let rule = match spec.one_of("line", "depth", &["depth", "eye", "even"])? {
        "eye" => Rule::Eye,
        "even" => Rule::Even,
        _ => Rule::Depth,
    };
    logarithmic(spec, rule)
}
