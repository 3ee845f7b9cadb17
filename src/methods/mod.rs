//! The methods of the literature behind one trait, on the same scene, camera, timers and reference.

use std::fmt;

/// A method as the user typed it: `name` or `name:key=value,key=value`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MethodSpec {
    /// Exactly as typed.
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
