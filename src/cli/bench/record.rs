//! What is kept of each frame of each method.

use crate::cli::results::LightErrors;
use umbrage::methods::{FrameTimes, MethodSpec};
use umbrage::truth::Crawl;

/// The counters of pages, as named by the methods that have pages.
pub const PAGES: [&str; 5] = ["pages_requested", "pages_hit", "pages_drawn", "pages_deferred", "pages_evicted"];

/// One frame of one method.
#[derive(Debug, Clone, Default)]
pub struct Record {
    pub times: FrameTimes,
    pub counters: Vec<(&'static str, u64)>,
    /// Device memory in bytes.
    pub bytes: u64,
    /// Where the frame was measured.
    pub errors: Option<LightErrors>,
    /// Over all lights, where this frame and the one before were measured.
    pub crawl: Option<Crawl>,
    /// Pixels whose visibility has other bits than that of the same method without its cache, where both were measured.
    pub differing: Option<u64>,
    /// Whether that one put something off.
    pub cold_put_off: bool,
}

/// The row of the same method without its cache.
pub fn cold(specs: &[MethodSpec], spec: &MethodSpec) -> Option<usize> {
    let is_cache = |(key, _): &&(String, String)| key == "cache";
    let others = |s: &MethodSpec| {
        let mut keys: Vec<_> = s.parameters.iter().filter(|p| !is_cache(p)).cloned().collect();
        keys.sort();
        (s.name.clone(), keys)
    };
    specs.iter().position(|s| is_cold(s) && others(s) == others(spec))
}

/// Whether a method draws every page anew in each frame.
pub fn is_cold(spec: &MethodSpec) -> bool {
    spec.name == "rmsm" && spec.parameters.iter().any(|(key, value)| key == "cache" && value == "off")
}

impl Record {
    /// Whether the budgets put something off.
    pub fn put_off(&self) -> bool {
        self.counter("pages_deferred").is_some_and(|pages| pages > 0)
    }

    /// A counter, where the method has it.
    pub fn counter(&self, name: &str) -> Option<u64> {
        self.counters.iter().find(|(n, _)| *n == name).map(|&(_, value)| value)
    }
}
