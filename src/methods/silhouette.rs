//! Shadow silhouette maps (Sen, Cammarano, Hanrahan 2003; book, 4.6.2): beside a conventional map a second one, half a texel
//! off, whose texels hold a point of a silhouette edge as the light sees it. The lookup joins the points of neighbouring texels
//! and takes the depth test from the side of that line on which the sample lies: borders of shadows are lines, not staircases.

use super::comparison::Comparison;
use super::map::Screen;
use super::uniform::{self, Uniform};
use super::{MethodInfo, Parameter};

const RESOLUTION: u32 = 1024;

const PARAMETERS: [Parameter; 5] = Comparison::hard_keys(&[
    Parameter {
        default: "1024",
        meaning: "side of both maps in texels; a cube's maps share the same number of texels",
        ..uniform::SIDE
    },
    uniform::FIT,
]);

pub(super) const INFO: MethodInfo = MethodInfo {
    name: "silhouette",
    source: "Sen, Cammarano, Hanrahan 2003; Eisemann et al. 2011, 4.6.2",
    summary: "A fitted map beside one that holds points of the casters' silhouettes, which are found on the GPU in every frame",
    parameters: &PARAMETERS,
    check: |spec| uniform::settings(spec, RESOLUTION).map(|_| ()),
    create: |spec, lab| {
        let settings = uniform::settings(spec, RESOLUTION)?;
        Ok(Box::new(Uniform::new(spec, lab, settings, Screen::with_edges(lab)?)?))
    },
};
