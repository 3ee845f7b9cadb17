//! Light-space perspective shadow maps (Wimmer, Scherzer, Purgathofer 2004; book, 4.2): a perspective warp along the view
//! direction as the light sees it, which keeps the light parallel.

use super::comparison::Comparison;
use super::warp::{RESOLUTION, Settings, WARP, Warp, settings};
use super::warp_passes::Rule;
use super::{MethodInfo, MethodSpec, Parameter};
use crate::lab::LabError;

const PARAMETERS: [Parameter; 8] = Comparison::keys(&[
    RESOLUTION,
    Parameter {
        key: "distance",
        default: "auto",
        allowed: "auto or 0.001 to 1000000",
        meaning: "from the warp's line to the nearest sample, world units; auto spreads the error evenly (book, 4.17)",
    },
    WARP,
]);

pub(super) const INFO: MethodInfo = MethodInfo {
    name: "lispsm",
    source: "Wimmer, Scherzer, Purgathofer 2004; Eisemann et al. 2011, 4.2",
    summary: "One map, warped so that texels are smaller near the eye, by the parameter that spreads the error evenly",
    parameters: &PARAMETERS,
    check: |spec| parse(spec).map(|_| ()),
    create: |spec, lab| Ok(Box::new(Warp::new(INFO.name, spec, lab, parse(spec)?)?)),
};

fn parse(spec: &MethodSpec) -> Result<Settings, LabError> {
    let rule =
        if spec.is_auto("distance") { Rule::Even } else { Rule::Distance(spec.f32_in("distance", 1.0, 1e-3..=1e6)?) };
    settings(spec, rule)
}
