//! How a map method compares a sample with what its map holds: the keys `bias`, `depth_bias`, `cull`, `filter` and `taps`.

use super::{MethodSpec, Parameter};
use crate::lab::LabError;
use crate::{Cull, Filter};

/// What the five keys say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Comparison {
    pub(super) bias: BiasKind,
    /// Texels, for the filter's kernel.
    pub(super) bias_texels: f32,
    pub(super) cull: Cull,
    pub(super) filter: Filter,
    /// Whether the plane's bias shrinks to nothing towards the middle of a texel: for methods that trust lookups there alone.
    pub(super) centred: bool,
    /// Texels around a sample's own, either way, that a hard comparison reads too.
    pub(super) search: u32,
}

impl Comparison {
    pub(super) fn of(spec: &MethodSpec) -> Result<Self, LabError> {
        let filter = filter(spec)?;
        let (bias, cull) = bias_kind(spec)?;
        Ok(Self { bias, bias_texels: depth_bias(spec)? * filter.bias(), cull, filter, centred: false, search: 0 })
    }

    /// A method's own keys, then the five.
    pub(super) const fn keys<const N: usize>(own: &[Parameter]) -> [Parameter; N] {
        joined(own, &[BIAS, DEPTH_BIAS, CULL, FILTER[0], FILTER[1]])
    }

    /// The same of a method that filters nothing.
    pub(super) const fn hard_keys<const N: usize>(own: &[Parameter]) -> [Parameter; N] {
        joined(own, &[BIAS, DEPTH_BIAS, CULL])
    }
}

const fn joined<const N: usize>(own: &[Parameter], rest: &[Parameter]) -> [Parameter; N] {
    assert!(own.len() + rest.len() == N);
    let mut all = [BIAS; N];
    let mut i = 0;
    while i < N {
        all[i] = if i < own.len() { own[i] } else { rest[i - own.len()] };
        i += 1;
    }
    all
}

/// How the map methods keep surfaces from shadowing themselves; as in `glsl/methods/bias.glsl`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum BiasKind {
    /// By the receiver's plane.
    Plane,
    /// By a constant (book, 2.2.3).
    Constant,
    /// By a constant and the slope (book, 2.2.3).
    Slope,
    /// By sides turned away from the light in place of those turned to it (Wang, Molnar 1994; book, 2.2.4).
    Second,
    /// By the middle between the first surface and the second (Woo 1992; book, 2.2.4).
    Midpoint,
    /// By the lesser of that and a constant (Weiskopf, Ertl 2003; book, 2.2.4).
    Dual,
    /// By the receiver's triangle, where the map holds it, or else a constant (Hourcade, Nicolas 1985; Fernando 2002, ch. 2).
    Ids,
}

impl BiasKind {
    /// Whether the second surface is drawn too.
    pub(super) fn peels(self) -> bool {
        matches!(self, BiasKind::Midpoint | BiasKind::Dual)
    }
}

/// The key `bias` of the map methods.
const BIAS: Parameter = Parameter {
    key: "bias",
    default: "plane",
    allowed: "plane, constant, slope, second, midpoint, dual or ids",
    meaning: "what keeps surfaces from shadowing themselves: the receiver's plane, a constant, that and the slope, the sides turned away, the middle to the second surface, the lesser of that and a constant, or the triangle's own number and else a constant",
};

/// The key `depth_bias` of the map methods.
pub(super) const DEPTH_BIAS: Parameter = Parameter {
    key: "depth_bias",
    default: "1",
    allowed: "0 to 16",
    meaning: "depth bias beyond the receiver plane's, in texels plus a quarter of their slope, times half a filter's taps",
};

fn depth_bias(spec: &MethodSpec) -> Result<f32, LabError> {
    spec.f32_in(DEPTH_BIAS.key, 1.0, 0.0..=16.0)
}

/// The key `cull` of the map methods.
pub(super) const CULL: Parameter = Parameter {
    key: "cull",
    default: "none",
    allowed: "none, back or front",
    meaning: "sides of casters left out, as the light sees them",
};

pub(super) fn cull(spec: &MethodSpec) -> Result<Cull, LabError> {
    Ok(match spec.one_of(CULL.key, CULL.default, &["none", "back", "front"])? {
        "back" => Cull::Back,
        "front" => Cull::Front,
        _ => Cull::None,
    })
}
/// The keys of [`filter`].
pub(super) const FILTER: [Parameter; 2] = [
    Parameter {
        key: "filter",
        default: "hard",
        allowed: "hard, pcf, poisson or bilinear",
        meaning: "hard shadows, or kernels: nearest texels, points of a disc, or bilinear lookups",
    },
    Parameter { key: "taps", default: "4", allowed: "2 to 9", meaning: "texels along a side of the filter's kernel" },
];

pub(super) fn filter(spec: &MethodSpec) -> Result<Filter, LabError> {
    let taps = spec.u32_in("taps", 4, 2..=9)?;
    Ok(match spec.one_of("filter", "hard", &["hard", "pcf", "poisson", "bilinear"])? {
        "pcf" => Filter::Pcf { taps },
        "poisson" => Filter::Poisson { taps },
        "bilinear" => Filter::Bilinear { taps },
        _ => Filter::Hard,
    })
}

/// With what is left out of the map, which `second` decides itself.
fn bias_kind(spec: &MethodSpec) -> Result<(BiasKind, Cull), LabError> {
    let kinds = ["plane", "constant", "slope", "second", "midpoint", "dual", "ids"];
    let kind = match spec.one_of(BIAS.key, BIAS.default, &kinds)? {
        "constant" => BiasKind::Constant,
        "slope" => BiasKind::Slope,
        "second" => BiasKind::Second,
        "midpoint" => BiasKind::Midpoint,
        "dual" => BiasKind::Dual,
        "ids" => BiasKind::Ids,
        _ => BiasKind::Plane,
    };
    let cull = cull(spec)?;
    let refused = |key, allowed| {
        Err(LabError::Usage(format!(
            "method '{spec}' has bias={} and a {key}, allowed is {allowed}",
            kinds[kind as usize]
        )))
    };
    if kind == BiasKind::Second && spec.value(CULL.key).is_some() {
        return refused(CULL.key, "none: it leaves out the sides turned to the light");
    }
    if kind != BiasKind::Plane && filter(spec)? != Filter::Hard {
        return refused(FILTER[0].key, "filter=hard");
    }
    Ok((kind, if kind == BiasKind::Second { Cull::Front } else { cull }))
}
