//! Parses what the user typed after `--method` and `--methods`, and hands the values to the methods.

use super::{METHODS, Parameter};
use crate::lab::LabError;
use std::fmt::{self, Display};
use std::ops::RangeInclusive;
use std::str::FromStr;

/// A method as the user typed it: `name` or `name:key=value,key=value`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MethodSpec {
    /// As typed, or as [`Self::with`] and [`Self::without`] put it.
    pub text: String,
    /// The part before the colon.
    pub name: String,
    /// Keys and values in the order typed.
    pub parameters: Vec<(String, String)>,
}

impl fmt::Display for MethodSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// Whether a piece between commas belongs to the method before it.
fn continues(piece: &str) -> bool {
    piece.contains('=') && !piece.contains(':')
}

impl MethodSpec {
    /// Reads one method; the error is one sentence. Whether name and keys exist is for [`super::check`] to say.
    pub fn parse(text: &str) -> Result<Self, String> {
        // `name,key=value` means what the list rule makes of it, so a colon is not the only end of a name
        let end = text.find([':', ',']).unwrap_or(text.len());
        let (name, rest) = (text[..end].trim(), text.get(end + 1..));
        if name.is_empty() || name.contains('=') {
            return Err(format!("method '{text}' has no name, allowed is NAME[:key=value,...]"));
        }
        let mut parameters: Vec<(String, String)> = Vec::new();
        for piece in rest.into_iter().flat_map(|r| r.split(',')) {
            let (key, value) = piece.split_once('=').map(|(k, v)| (k.trim(), v.trim())).unwrap_or((piece.trim(), ""));
            if key.is_empty() || value.is_empty() {
                return Err(format!("method '{text}' has the piece '{piece}', allowed is key=value"));
            }
            if parameters.iter().any(|(known, _)| known == key) {
                return Err(format!("method '{text}' has the key '{key}' twice, allowed is once"));
            }
            parameters.push((key.to_owned(), value.to_owned()));
        }
        Ok(Self { text: text.to_owned(), name: name.to_owned(), parameters })
    }

    /// Reads a comma-separated list: a piece with `=` and no `:` continues the method before it.
    pub fn parse_list(text: &str) -> Result<Vec<Self>, String> {
        let mut methods: Vec<String> = Vec::new();
        for piece in text.split(',') {
            match methods.last_mut() {
                Some(method) if continues(piece) => {
                    method.push(',');
                    method.push_str(piece);
                }
                _ => methods.push(piece.trim().to_owned()),
            }
        }
        methods.iter().map(|method| Self::parse(method)).collect()
    }

    /// Whether the method has a key.
    pub fn knows(&self, key: &str) -> bool {
        METHODS.iter().any(|m| m.name == self.name && m.parameters.iter().any(|p| p.key == key))
    }

    /// The method without a key.
    pub fn without(&self, key: &str) -> Self {
        Self::of(&self.name, self.parameters.iter().filter(|(k, _)| k != key).cloned().collect())
    }

    /// The method with a key set, in the place where it was typed or as the last.
    pub fn with(&self, key: &str, value: &str) -> Self {
        let mut parameters = self.parameters.clone();
        match parameters.iter_mut().find(|(k, _)| k == key) {
            Some((_, old)) => *old = value.to_owned(),
            None => parameters.push((key.to_owned(), value.to_owned())),
        }
        Self::of(&self.name, parameters)
    }

    fn of(name: &str, parameters: Vec<(String, String)>) -> Self {
        let keys: Vec<_> = parameters.iter().map(|(k, v)| format!("{k}={v}")).collect();
        let colon = if keys.is_empty() { "" } else { ":" };
        Self { text: format!("{name}{colon}{}", keys.join(",")), name: name.to_owned(), parameters }
    }

    /// The value typed for `key`.
    pub(crate) fn value(&self, key: &str) -> Option<&str> {
        self.parameters.iter().find(|(k, _)| k == key).map(|(_, v)| v.as_str())
    }

    /// Whether a key that may be `auto` is.
    pub(crate) fn is_auto(&self, key: &str) -> bool {
        self.value(key).is_none_or(|value| value == "auto")
    }

    /// Refuses keys that are not in `parameters`.
    pub(crate) fn known(&self, parameters: &[Parameter]) -> Result<(), LabError> {
        for (key, _) in &self.parameters {
            if !parameters.iter().any(|p| p.key == key) {
                let keys: Vec<_> = parameters.iter().map(|p| p.key).collect();
                let allowed = if keys.is_empty() { "no key".to_owned() } else { keys.join(", ") };
                return Err(LabError::Usage(format!(
                    "method '{}' has no key '{key}', allowed is {allowed}",
                    self.name
                )));
            }
        }
        Ok(())
    }

    /// A value that is not allowed.
    pub(crate) fn refuse(&self, key: &str, value: &str, allowed: impl Display) -> LabError {
        LabError::Usage(format!("key '{key}' of method '{}' is '{value}', allowed is {allowed}", self.name))
    }

    fn number_in<T>(&self, key: &str, default: T, range: RangeInclusive<T>, kind: &str) -> Result<T, LabError>
    where
        T: FromStr + PartialOrd + Display,
    {
        let Some(text) = self.value(key) else { return Ok(default) };
        let allowed = || format!("{kind} from {} to {}", range.start(), range.end());
        // a NaN is in no range
        text.parse().ok().filter(|v| range.contains(v)).ok_or_else(|| self.refuse(key, text, allowed()))
    }

    /// The whole number typed for `key`, or the default.
    pub(crate) fn u32_in(&self, key: &str, default: u32, range: RangeInclusive<u32>) -> Result<u32, LabError> {
        self.number_in(key, default, range, "a whole number")
    }

    /// The number typed for `key`, or the default.
    pub(crate) fn f32_in(&self, key: &str, default: f32, range: RangeInclusive<f32>) -> Result<f32, LabError> {
        self.number_in(key, default, range, "a number")
    }

    /// The word typed for `key`, or the default; always one of `allowed` or the default.
    pub(crate) fn one_of<'a>(&self, key: &str, default: &'a str, allowed: &[&'a str]) -> Result<&'a str, LabError> {
        let Some(text) = self.value(key) else { return Ok(default) };
        allowed.iter().find(|a| **a == text).copied().ok_or_else(|| self.refuse(key, text, allowed.join(" or ")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(list: &str) -> Vec<String> {
        MethodSpec::parse_list(list).unwrap().into_iter().map(|m| m.text).collect()
    }

    fn keyed() -> MethodSpec {
        MethodSpec::parse("m:n=12,f=0.5,w=sort,bad=x").unwrap()
    }

    #[test]
    fn one_method() {
        let spec = MethodSpec::parse("rmsm:atlas_mib=64,level=area").unwrap();
        assert_eq!((spec.name.as_str(), spec.parameters.len()), ("rmsm", 2));
        assert_eq!(spec.value("level"), Some("area"));
        assert_eq!(spec.to_string(), "rmsm:atlas_mib=64,level=area");
        assert!(MethodSpec::parse("rmsm").unwrap().parameters.is_empty());
    }

    #[test]
    fn a_list_keeps_the_text_as_typed() {
        assert_eq!(texts("rmsm,uniform:resolution=4096"), ["rmsm", "uniform:resolution=4096"]);
        assert_eq!(
            texts("rmsm:bias=1,level=area,uniform:fit=scene,resolution=8192,raytraced"),
            ["rmsm:bias=1,level=area", "uniform:fit=scene,resolution=8192", "raytraced"]
        );
        assert_eq!(texts("rmsm,bias=1,rmsm"), ["rmsm,bias=1", "rmsm"]);
        assert_eq!(MethodSpec::parse_list("rmsm,bias=1").unwrap()[0].value("bias"), Some("1"));
    }

    #[test]
    fn keys_are_set_and_taken_away() {
        let spec = MethodSpec::parse("rmsm:bias=1,level=area").unwrap();
        assert_eq!(spec.with("bias", "2").text, "rmsm:bias=2,level=area");
        assert_eq!(spec.with("page", "64"), MethodSpec::parse("rmsm:bias=1,level=area,page=64").unwrap());
        assert_eq!(spec.without("bias").without("level"), MethodSpec::parse("rmsm").unwrap());
        assert!(spec.knows("page") && !spec.knows("resolution") && !keyed().knows("n"));
    }

    #[test]
    fn bad_text_is_named() {
        for text in ["", ":", "rmsm:", "rmsm:bias", "rmsm:bias=", "rmsm:=1", "bias=1", "rmsm:a=1,a=2", "rmsm:a=1,,b=2"]
        {
            let error = MethodSpec::parse(text).unwrap_err();
            assert!(error.contains(&format!("'{text}'")) && error.contains("allowed is"), "{text}: {error}");
        }
        for list in ["", "rmsm,", ",rmsm", "bias=1,rmsm", "rmsm,,uniform"] {
            assert!(MethodSpec::parse_list(list).is_err(), "{list}");
        }
    }

    #[test]
    fn values_in_range() {
        let spec = keyed();
        assert_eq!(spec.u32_in("n", 1, 1..=12).unwrap(), 12);
        assert_eq!(spec.u32_in("absent", 7, 1..=2).unwrap(), 7);
        assert_eq!(spec.f32_in("f", 1.0, 0.0..=1.0).unwrap(), 0.5);
        assert_eq!(spec.one_of("w", "flags", &["sort", "flags"]).unwrap(), "sort");
        assert_eq!(spec.one_of("absent", "flags", &["sort", "flags"]).unwrap(), "flags");
    }

    #[test]
    fn values_out_of_range_are_usage_errors() {
        let spec = keyed();
        let nan = MethodSpec::parse("m:f=nan").unwrap();
        let errors = [
            spec.u32_in("n", 1, 1..=11).unwrap_err(),
            spec.u32_in("bad", 1, 1..=11).unwrap_err(),
            spec.f32_in("f", 1.0, 0.6..=1.0).unwrap_err(),
            nan.f32_in("f", 1.0, 0.0..=1.0).unwrap_err(),
            spec.one_of("bad", "sort", &["sort", "flags"]).unwrap_err(),
        ];
        for error in errors {
            assert!(
                matches!(&error, LabError::Usage(text) if text.contains("of method 'm'") && text.contains("allowed is")),
                "{error}"
            );
        }
        assert!(spec.u32_in("n", 1, 1..=11).unwrap_err().to_string().contains("from 1 to 11"));
    }

    #[test]
    fn unknown_keys_list_the_known_ones() {
        let parameter = |key| Parameter { key, default: "1", allowed: "1 to 2", meaning: "" };
        let known = [parameter("n"), parameter("f"), parameter("w")];
        let error = keyed().known(&known).unwrap_err().to_string();
        assert_eq!(error, "method 'm' has no key 'bad', allowed is n, f, w");
        assert!(MethodSpec::parse("m:n=1").unwrap().known(&known).is_ok());
    }
}
