//! `--sweep KEY=VALUES`: methods that run once for every value of a key.

mod charts;

pub use charts::{Plot, draw as plots};

use serde::{Serialize, Serializer};
use umbrage::lab::LabError;
use umbrage::methods::{self, METHODS, MethodSpec};

const ALLOWED: &str = "allowed is KEY=A,B,... or KEY=FIRST..LAST";

/// A key and the values it takes by turns, as typed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Sweep {
    pub key: String,
    pub values: Vec<String>,
}

/// One run of a sweep, or a method that is run without one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Variant {
    pub spec: MethodSpec,
    /// `None` for methods that do not know the key.
    pub swept: Option<Swept>,
}

/// Where in a sweep a run belongs.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Swept {
    /// The method without the key: the runs of a line.
    pub of: String,
    /// In JSON a number where it is one.
    #[serde(serialize_with = "number_or_text")]
    pub value: String,
}

fn number_or_text<S: Serializer>(value: &str, serializer: S) -> Result<S::Ok, S::Error> {
    match number(value) {
        Some(number) => serializer.serialize_f64(number),
        None => serializer.serialize_str(value),
    }
}

fn number(value: &str) -> Option<f64> {
    value.parse().ok().filter(|number: &f64| number.is_finite())
}

impl Sweep {
    /// Reads what follows `--sweep`; the error is one sentence.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (key, values) = text.split_once('=').ok_or(ALLOWED)?;
        let (key, values) = (key.trim(), values.trim());
        if key.is_empty() || values.is_empty() {
            return Err(ALLOWED.into());
        }
        let values: Vec<String> = match values.split_once("..") {
            Some((first, last)) => doubled(first, last).ok_or(format!(
                "the range is {values}, allowed are whole numbers from 1 of which the last is the first doubled some times"
            ))?,
            None => values.split(',').map(|value| value.trim().to_owned()).collect(),
        };
        if values.iter().any(String::is_empty) {
            return Err(format!("one of the values is empty, {ALLOWED}"));
        }
        let same = |a: &str, b: &str| a == b || number(a).is_some_and(|a| number(b) == Some(a));
        let twice = values.iter().enumerate().find(|(i, value)| values[..*i].iter().any(|before| same(before, value)));
        match twice {
            Some((_, value)) => Err(format!("the value {value} is there twice, allowed is once")),
            None => Ok(Self { key: key.to_owned(), values }),
        }
    }

    /// The values as numbers, where all of them are.
    fn numbers(&self) -> Option<Vec<f64>> {
        self.values.iter().map(|value| number(value)).collect()
    }
}

/// `first`, twice as much, and so on up to `last`.
fn doubled(first: &str, last: &str) -> Option<Vec<String>> {
    let [first, last]: [u32; 2] = [first.trim().parse().ok()?, last.trim().parse().ok()?];
    let values: Vec<u32> = std::iter::successors(Some(first.max(1)), |value| value.checked_mul(2))
        .take_while(|&value| value <= last)
        .collect();
    (first > 0 && values.last() == Some(&last)).then(|| values.iter().map(u32::to_string).collect())
}

/// The methods in their order, those that know the key of the sweep once for every value.
pub fn variants(methods: &[MethodSpec], sweep: Option<&Sweep>) -> Result<Vec<Variant>, LabError> {
    let once = |spec: &MethodSpec| Variant { spec: spec.clone(), swept: None };
    let Some(sweep) = sweep else { return Ok(methods.iter().map(once).collect()) };
    if !methods.iter().any(|spec| spec.knows(&sweep.key)) {
        return Err(LabError::Usage(unknown(methods, &sweep.key)));
    }
    let mut list = Vec::new();
    for spec in methods {
        if !spec.knows(&sweep.key) {
            list.push(once(spec));
            continue;
        }
        for value in &sweep.values {
            let swept = Some(Swept { of: spec.without(&sweep.key).text, value: value.clone() });
            let spec = spec.with(&sweep.key, value);
            methods::check(&spec)?;
            list.push(Variant { spec, swept });
        }
    }
    Ok(list)
}

/// That no method knows a key, and what they know.
fn unknown(methods: &[MethodSpec], key: &str) -> String {
    let known = METHODS.iter().filter(|m| methods.iter().any(|spec| spec.name == m.name));
    let mut keys: Vec<_> = known.flat_map(|m| m.parameters.iter().map(|p| p.key)).collect();
    keys.sort_unstable();
    keys.dedup();
    let names: Vec<_> = methods.iter().map(|spec| spec.text.as_str()).collect();
    format!("none of the methods {} has the key '{key}' of --sweep, allowed is {}", names.join(", "), keys.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(text: &str) -> Vec<String> {
        Sweep::parse(text).unwrap().values
    }

    fn runs(methods: &str, sweep: &str) -> Result<Vec<String>, LabError> {
        let (methods, sweep) = (MethodSpec::parse_list(methods).unwrap(), Sweep::parse(sweep).unwrap());
        Ok(variants(&methods, Some(&sweep))?.into_iter().map(|variant| variant.spec.text).collect())
    }

    #[test]
    fn lists_and_ranges() {
        assert_eq!(values("bias=-3, 0,0.5"), ["-3", "0", "0.5"]);
        assert_eq!(values("pressure=demand,level"), ["demand", "level"]);
        assert_eq!(values("resolution=512..4096"), ["512", "1024", "2048", "4096"]);
        assert_eq!([values("pages=3..12"), values("pages=7..7")], [vec!["3", "6", "12"], vec!["7"]]);
        assert_eq!(values("pages=2147483648..2147483648"), ["2147483648"]);
    }

    #[test]
    fn bad_text_is_named() {
        for text in ["", "=", "bias", "bias=", "=1", "bias=1,", "bias=1,,2", "bias= , "] {
            let error = Sweep::parse(text).unwrap_err();
            assert!(error.ends_with("allowed is KEY=A,B,... or KEY=FIRST..LAST"), "{text}: {error}");
        }
        for range in ["0..8", "3..8", "8..4", "-4..4", "0.5..2", "1..", "..2", "..", "a..b", "1..2..4", "1..4294967296"]
        {
            let error = Sweep::parse(&format!("bias={range}")).unwrap_err();
            assert!(error.contains(&format!("the range is {range}, allowed are")), "{range}: {error}");
        }
        for (list, twice) in [("1,2,1", "1"), ("1,1.0", "1.0"), ("area,area", "area")] {
            let error = Sweep::parse(&format!("level={list}")).unwrap_err();
            assert_eq!(error, format!("the value {twice} is there twice, allowed is once"));
        }
    }

    #[test]
    fn those_that_know_the_key_run_once_for_every_value() {
        assert_eq!(
            runs("raytraced,uniform:resolution=64,fit=scene,csm", "resolution=512..1024").unwrap(),
            [
                "raytraced",
                "uniform:resolution=512,fit=scene",
                "uniform:resolution=1024,fit=scene",
                "csm:resolution=512",
                "csm:resolution=1024"
            ]
        );
        let methods = MethodSpec::parse_list("rmsm:bias=1,page=64,raytraced").unwrap();
        let list = variants(&methods, Some(&Sweep::parse("bias=0").unwrap())).unwrap();
        assert_eq!(list[0].swept, Some(Swept { of: "rmsm:page=64".into(), value: "0".into() }));
        assert_eq!(list[1], Variant { spec: methods[1].clone(), swept: None });
        assert_eq!(variants(&methods, None).unwrap()[0].spec, methods[0]);
    }

    #[test]
    fn what_methods_refuse_is_named() {
        let error = runs("rmsm:page=64,raytraced", "resolution=512").unwrap_err().to_string();
        assert!(
            error.starts_with(
                "none of the methods rmsm:page=64, raytraced has the key 'resolution' of --sweep, allowed is atlas_mib, bias,"
            ) && error.contains(", turned,"),
            "{error}"
        );
        let error = runs("rmsm", "page=64,65").unwrap_err().to_string();
        assert!(error.contains("'page'") && error.contains("'65'") && error.contains("64 or 128"), "{error}");
    }

    #[test]
    fn values_are_numbers_in_json_where_they_can_be() {
        let json =
            |value: &str| serde_json::to_value(Swept { of: "m".into(), value: value.into() }).unwrap()["value"].clone();
        assert_eq!([json("16"), json("-0.5")], [16.0, -0.5].map(serde_json::Value::from));
        assert_eq!([json("level"), json("nan")], ["level", "nan"].map(serde_json::Value::from));
    }
}
