//! Plane-optimal perspective warping (Chong, Gortler 2004; book, 4.2.5): the perspective warp that is the camera's own on one
//! plane, whose texels look alike everywhere in the image of that plane.

use super::comparison::Comparison;
use super::plane::Plane;
use super::warp::{RESOLUTION, Settings, WARP, Warp, of_plane};
use super::{MethodInfo, MethodSpec, Parameter};
use crate::lab::LabError;
use glam::DVec3;

const PLANE: &str = "plane";
const PLANES: &str = "auto or NX/NY/NZ/D";

const PARAMETERS: [Parameter; 8] = Comparison::keys(&[
    RESOLUTION,
    Parameter {
        key: PLANE,
        default: "auto",
        allowed: PLANES,
        meaning: "the plane whose texels look alike: normal (any length but 0) and offset N . X = D, world units; auto is that of most of the samples",
    },
    WARP,
]);

pub(super) const INFO: MethodInfo = MethodInfo {
    name: "plane_optimal",
    source: "Chong, Gortler 2004; Eisemann et al. 2011, 4.2.5",
    summary: "One map, warped so that texels look alike all over one plane, given or found",
    parameters: &PARAMETERS,
    check: |spec| parse(spec).map(|_| ()),
    create: |spec, lab| Ok(Box::new(Warp::new(INFO.name, spec, lab, parse(spec)?)?)),
};

fn parse(spec: &MethodSpec) -> Result<Settings, LabError> {
    let plane = match spec.value(PLANE) {
        Some(text) if text != "auto" => given(text).ok_or_else(|| spec.refuse(PLANE, text, PLANES))?,
        _ => Plane::Dominant,
    };
    of_plane(spec, plane)
}

fn given(text: &str) -> Option<Plane> {
    let numbers: Vec<f64> = text.split('/').map(|number| number.parse().ok()).collect::<Option<_>>()?;
    let [x, y, z, offset] = numbers[..].try_into().ok()?;
    let normal = DVec3::new(x, y, z);
    let length = normal.length();
    (length > 0.0 && length.is_finite() && offset.is_finite()).then(|| Plane::Given(normal / length, offset / length))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_are_four_numbers() {
        assert_eq!(given("0/2/0/-3"), Some(Plane::Given(DVec3::Y, -1.5)));
        for text in ["", "0/1/0", "0/1/0/2/3", "0/0/0/1", "0/a/0/1", "0/1/0/inf", "nan/1/0/0", "0,1,0,2"] {
            assert_eq!(given(text), None, "{text}");
        }
    }
}
