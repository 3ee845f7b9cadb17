//! Changes to a method's keys.

use crate::methods::{METHODS, MethodSpec};

const FILTERS: [&str; 4] = ["hard", "pcf", "poisson", "bilinear"];

/// Whether a method has pages.
pub(super) fn paged(spec: &MethodSpec) -> bool {
    spec.knows("atlas_mib")
}

/// A key's value, typed or default.
fn value<'a>(spec: &'a MethodSpec, key: &str) -> Option<&'a str> {
    let method = METHODS.iter().find(|m| m.name == spec.name)?;
    let default = method.parameters.iter().find(|p| p.key == key)?.default;
    Some(spec.parameters.iter().find(|(k, _)| k == key).map_or(default, |(_, v)| v.as_str()))
}

/// The method with a key set; one that has its default is left out.
fn with(spec: &MethodSpec, key: &str, value: &str) -> MethodSpec {
    let method = METHODS.iter().find(|m| m.name == spec.name);
    let default = method.and_then(|m| m.parameters.iter().find(|p| p.key == key)).map(|p| p.default);
    if default == Some(value) { spec.without(key) } else { spec.with(key, value) }
}

/// Rays on or off; they come without a filter.
pub(super) fn exact(spec: &MethodSpec) -> Option<MethodSpec> {
    let on = value(spec, "exact")? != "true";
    let spec = with(spec, "exact", if on { "true" } else { "false" });
    Some(if on { with(&with(&spec, "filter", "hard"), "blend", "false") } else { with(&spec, "samples", "1") })
}

/// The next filter; filters come without rays.
pub(super) fn filter(spec: &MethodSpec) -> Option<MethodSpec> {
    let at = FILTERS.iter().position(|f| value(spec, "filter") == Some(f))?;
    let next = FILTERS[(at + 1) % FILTERS.len()];
    let mut changed = with(spec, "filter", next);
    if next != "hard" && spec.knows("exact") {
        changed = with(&with(&changed, "exact", "false"), "samples", "1");
    }
    if next == "hard" && spec.knows("blend") {
        changed = with(&changed, "blend", "false");
    }
    Some(changed)
}

/// The finest level by one finer or coarser.
pub(super) fn bias(spec: &MethodSpec, finer: bool) -> Option<MethodSpec> {
    let bias: f32 = value(spec, "bias")?.parse().ok()?;
    Some(with(spec, "bias", &(bias + if finer { -1.0 } else { 1.0 }).to_string()))
}

/// Half or twice the memory of the atlas, or half or twice the side of the map.
pub(super) fn atlas(spec: &MethodSpec, larger: bool) -> Option<MethodSpec> {
    let key = ["atlas_mib", "resolution"].into_iter().find(|key| spec.knows(key))?;
    let size: u32 = value(spec, key)?.parse().ok()?;
    let changed = if larger { size.saturating_mul(2) } else { size / 2 };
    Some(with(spec, key, &changed.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::check;

    fn spec(text: &str) -> MethodSpec {
        MethodSpec::parse(text).unwrap()
    }

    #[test]
    fn every_change_parses_again() {
        for text in
            ["rmsm", "rmsm:exact=true,samples=4", "rmsm:filter=pcf,blend=true", "uniform:resolution=1024", "csm"]
        {
            let start = spec(text);
            let steps = [exact(&start), filter(&start), bias(&start, true), atlas(&start, true), atlas(&start, false)];
            for changed in steps.into_iter().flatten() {
                assert_eq!(MethodSpec::parse(&changed.text).unwrap(), changed, "{text}");
                check(&changed).unwrap();
            }
        }
    }

    #[test]
    fn rays_and_filters_exclude_each_other() {
        let rays = exact(&spec("rmsm:filter=poisson,taps=6")).unwrap();
        assert_eq!(
            [value(&rays, "exact"), value(&rays, "filter"), value(&rays, "taps")],
            [Some("true"), Some("hard"), Some("6")]
        );
        let filtered = filter(&spec("rmsm:exact=true,samples=8")).unwrap();
        assert_eq!(
            ["exact", "samples", "filter"].map(|k| value(&filtered, k)),
            [Some("false"), Some("1"), Some("pcf")]
        );
        assert_eq!(value(&exact(&rays).unwrap(), "exact"), Some("false"));
    }

    #[test]
    fn a_round_of_filters_ends_where_it_began() {
        let round = (0..4).try_fold(spec("uniform"), |spec, _| filter(&spec)).unwrap();
        assert_eq!(value(&round, "filter"), Some("hard"));
    }

    #[test]
    fn methods_without_a_key_say_so() {
        assert_eq!(exact(&spec("uniform")), None);
        assert_eq!(bias(&spec("csm"), true), None);
        assert_eq!(filter(&spec("raytraced")), None);
        assert_eq!(atlas(&spec("raytraced"), true), None);
        assert_eq!(atlas(&spec("uniform"), true).unwrap().text, "uniform:resolution=8192");
        assert_eq!(bias(&spec("rmsm"), true).unwrap().text, "rmsm:bias=-4");
        assert_eq!(bias(&spec("rmsm:bias=-4"), false).unwrap().text, "rmsm");
    }
}
