//! What is kept of each frame of each method.

use crate::cli::report::Errors;
use umbrage::methods::FrameTimes;
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
    pub errors: Option<Errors>,
    /// Where this frame and the one before were measured.
    pub crawl: Option<Crawl>,
}

impl Record {
    /// A counter, where the method has it.
    pub fn counter(&self, name: &str) -> Option<u64> {
        self.counters.iter().find(|(n, _)| *n == name).map(|&(_, value)| value)
    }
}
