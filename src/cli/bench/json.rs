//! What `bench.json` holds.

use super::record::{PAGES, Record, cold, is_cold};
use crate::cli::failure::Failure;
use crate::cli::measure::{Spread, Tail};
use crate::cli::results::{LightErrors, Named};
use serde::Serialize;
use serde_json::ser::Formatter;
use std::io::{self, Write};
use umbrage::lab::View;
use umbrage::methods::MethodSpec;
use umbrage::truth::Crawl;

/// `bench.json`.
#[derive(Debug, Serialize)]
pub struct Bench<'a> {
    pub device: String,
    pub driver: String,
    pub scene: &'a str,
    pub path: &'a str,
    pub view: &'a View,
    pub animate: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub movers: Option<u32>,
    pub copies: u32,
    pub sun_rate_deg_per_s: f64,
    pub truth_every: u32,
    pub seed: u64,
    pub runs: Vec<Run<'a>>,
}

/// One method over all frames.
#[derive(Debug, Serialize)]
pub struct Run<'a> {
    pub method: &'a str,
    /// Whole frame after the depth prepass, in milliseconds.
    pub ms: Tail,
    /// Median over the first method's median.
    pub ratio_median: f64,
    /// 95th percentile over the first method's.
    pub ratio_p95: f64,
    /// Median over the median of the first `uniform`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ratio_uniform: Option<f64>,
    /// Median and 95th percentile over those of drawing the map and looking it up alone of the first `uniform`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ratio_map_lookup: Option<Ratios>,
    /// Median over the median of the same method without its cache, or of the first `rmsm` without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ratio_cold: Option<f64>,
    /// Device memory, the most of all frames.
    pub bytes: u64,
    /// Page counters over all frames, where the method has them.
    pub pages: Named<Tail>,
    /// Percent of decided pixels, over the measured frames.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mismatch: Option<Tail>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub crawl: Option<CrawlSummary>,
    /// Against the same method without its cache, over the measured frames.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cold: Option<ColdSummary>,
    frames: Vec<Frame<'a>>,
}

/// Ratios of two methods' times.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Ratios {
    pub median: f64,
    pub p95: f64,
}

/// Medians over the frames in percent of decided pixels; `ratio` is the sum of flips over that of the reference's flips.
#[derive(Debug, Serialize)]
pub struct CrawlSummary {
    pub flips: f64,
    pub reference_flips: f64,
    /// Null where the reference never flips.
    pub ratio: Option<f64>,
    pub crawl: f64,
}

#[derive(Debug, Serialize)]
struct Frame<'a> {
    frame: usize,
    ms: f64,
    prepass_ms: f64,
    wall_ms: f64,
    bytes: u64,
    stages: Pairs<'a, f64>,
    counters: Pairs<'a, u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    errors: Option<&'a LightErrors>,
    #[serde(skip_serializing_if = "Option::is_none")]
    crawl: Option<Flips>,
    /// From the same method without its cache.
    #[serde(skip_serializing_if = "Option::is_none")]
    differing_pixels: Option<u64>,
}

#[derive(Debug, Serialize)]
struct Flips {
    flips: f64,
    reference_flips: f64,
    crawl: f64,
}

/// Named values as a JSON object that keeps their order.
#[derive(Debug)]
struct Pairs<'a, T>(&'a [(&'static str, T)]);

impl<T: Serialize> Serialize for Pairs<'_, T> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, value)| (name, value)))
    }
}

impl<'a> Run<'a> {
    /// What each method's frames come to; the first method is the measure of the others.
    pub fn of(specs: &'a [MethodSpec], records: &'a [Vec<Record>]) -> Vec<Self> {
        let tails: Vec<Tail> = records.iter().map(|frames| Tail::of(frames.iter().map(|f| f.times.ms))).collect();
        let uniform = specs.iter().position(|s| s.name == "uniform");
        let drawing = |f: &Record| f.times.stages.iter().filter(|s| matches!(s.0, "map" | "lookup")).map(|s| s.1).sum();
        let map_lookup = uniform.and_then(|u| records.get(u)).map(|frames| Tail::of(frames.iter().map(drawing)));
        let row = |i: usize| {
            let (spec, frames, ms) = (&specs[i], &records[i], tails[i]);
            let over = |other: Option<usize>| other.map(|other| ms.median / tails[other].median);
            let tail = |name| {
                let values: Vec<f64> = frames.iter().filter_map(|f| f.counter(name)).map(|n| n as f64).collect();
                (!values.is_empty()).then(|| (name, Tail::of(values)))
            };
            let mismatch: Vec<f64> = frames.iter().filter_map(|f| f.errors.as_ref().map(|e| e.all.mismatch)).collect();
            Self {
                method: &spec.text,
                ms,
                ratio_median: ms.median / tails[0].median,
                ratio_p95: ms.p95 / tails[0].p95,
                ratio_uniform: over(uniform),
                ratio_map_lookup: map_lookup.map(|m| Ratios { median: ms.median / m.median, p95: ms.p95 / m.p95 }),
                ratio_cold: over(cold_row(specs, spec)),
                bytes: frames.iter().map(|f| f.bytes).max().unwrap_or(0),
                pages: Named(PAGES.into_iter().filter_map(tail).collect()),
                mismatch: (!mismatch.is_empty()).then(|| Tail::of(mismatch)),
                crawl: CrawlSummary::of(frames),
                cold: ColdSummary::of(frames),
                frames: frames.iter().enumerate().map(|(i, record)| Frame::of(i, record)).collect(),
            }
        };
        (0..specs.len().min(records.len())).map(row).collect()
    }
}

/// The row that draws every page anew: that of the same method, or the first `rmsm` that does.
fn cold_row(specs: &[MethodSpec], spec: &MethodSpec) -> Option<usize> {
    cold(specs, spec).or_else(|| specs.iter().position(is_cold))
}

/// What the cache changed: nothing, unless the budgets put something off.
#[derive(Debug, Serialize)]
pub struct ColdSummary {
    /// Measured frames in which nothing was put off.
    pub whole_frames: usize,
    /// Most pixels that differ in one of them.
    pub differing_pixels: u64,
    /// Measured frames in which something was put off.
    pub put_off_frames: usize,
    /// Most pixels that differ in one of them.
    pub put_off_differing_pixels: u64,
}

impl ColdSummary {
    fn of(frames: &[Record]) -> Option<Self> {
        let (late, whole): (Vec<_>, Vec<_>) = frames
            .iter()
            .filter_map(|f| Some((f.put_off() || f.cold_put_off, f.differing?)))
            .partition(|(put_off, _)| *put_off);
        let most = |list: &[(bool, u64)]| list.iter().map(|(_, pixels)| *pixels).max().unwrap_or(0);
        (late.len() + whole.len() > 0).then(|| Self {
            whole_frames: whole.len(),
            differing_pixels: most(&whole),
            put_off_frames: late.len(),
            put_off_differing_pixels: most(&late),
        })
    }
}

impl CrawlSummary {
    fn of(frames: &[Record]) -> Option<Self> {
        let all: Vec<Crawl> = frames.iter().filter_map(|f| f.crawl).collect();
        let median = |value: fn(&Crawl) -> f64| Spread::of(all.iter().map(value)).median;
        let sum = |value: fn(&Crawl) -> f64| all.iter().map(value).sum::<f64>();
        let (flips, truth) = (sum(|c| c.flips), sum(|c| c.reference_flips));
        (!all.is_empty()).then(|| Self {
            flips: median(|c| c.flips),
            reference_flips: median(|c| c.reference_flips),
            ratio: (truth > 0.0).then(|| flips / truth),
            crawl: median(|c| c.crawl),
        })
    }
}

impl<'a> Frame<'a> {
    fn of(frame: usize, record: &'a Record) -> Self {
        let Record { times, counters, bytes, errors, crawl, differing, .. } = record;
        let flips = |c: Crawl| Flips { flips: c.flips, reference_flips: c.reference_flips, crawl: c.crawl };
        Self {
            frame,
            ms: times.ms,
            prepass_ms: times.prepass_ms,
            wall_ms: times.wall_ms,
            bytes: *bytes,
            stages: Pairs(&times.stages),
            counters: Pairs(counters),
            errors: errors.as_ref(),
            crawl: crawl.map(flips),
            differing_pixels: *differing,
        }
    }
}

/// The file's text: one line a frame.
pub fn text(bench: &Bench) -> Result<String, Failure> {
    let mut bytes = Vec::new();
    let mut serializer = serde_json::Serializer::with_formatter(&mut bytes, Lines::default());
    let written = bench.serialize(&mut serializer).map_err(|error| error.to_string());
    bytes.push(b'\n');
    written.and_then(|()| String::from_utf8(bytes).map_err(|error| error.to_string())).map_err(Failure::other)
}

/// Starts a line for each field of the file, of a run, and for each frame.
#[derive(Default)]
struct Lines {
    depth: usize,
}

/// Objects and lists around the fields of a frame.
const INSIDE_A_FRAME: usize = 5;

impl Lines {
    fn line(&self, writer: &mut (impl Write + ?Sized), first: bool) -> io::Result<()> {
        let comma = if first { "" } else { "," };
        if self.depth < INSIDE_A_FRAME {
            write!(writer, "{comma}\n{:1$}", "", self.depth)
        } else {
            writer.write_all(comma.as_bytes())
        }
    }
}

impl Formatter for Lines {
    fn begin_object<W: Write + ?Sized>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth += 1;
        writer.write_all(b"{")
    }

    fn end_object<W: Write + ?Sized>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth -= 1;
        writer.write_all(b"}")
    }

    fn begin_array<W: Write + ?Sized>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth += 1;
        writer.write_all(b"[")
    }

    fn end_array<W: Write + ?Sized>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth -= 1;
        writer.write_all(b"]")
    }

    fn begin_object_key<W: Write + ?Sized>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        self.line(writer, first)
    }

    fn begin_array_value<W: Write + ?Sized>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        self.line(writer, first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn specs(text: &str) -> Vec<MethodSpec> {
        MethodSpec::parse_list(text).unwrap()
    }

    #[test]
    fn the_cold_row_is_that_of_the_same_method() {
        let list = specs("rmsm,rmsm:bias=0,rmsm:cache=off,rmsm:cache=off,bias=0,uniform");
        let rows: Vec<_> = list.iter().map(|spec| cold_row(&list, spec)).collect();
        assert_eq!(rows, [Some(2), Some(3), Some(2), Some(3), Some(2)]);
        assert_eq!(cold_row(&specs("rmsm,uniform"), &specs("rmsm")[0]), None);
        assert_eq!(cold(&specs("rmsm:cache=off"), &specs("rmsm:bias=0")[0]), None);
    }

    #[test]
    fn ratios_are_to_the_first_method() {
        let list = specs("rmsm,uniform:resolution=1024");
        let run = |times: &[f64]| times.iter().map(|&ms| record(ms)).collect::<Vec<_>>();
        let mut records = [run(&[2.0, 4.0, 6.0]), run(&[1.0, 8.0, 9.0])];
        for frame in &mut records[1] {
            frame.times.stages = vec![("fit", 3.0), ("map", 1.5), ("lookup", 0.5)];
        }
        let runs = Run::of(&list, &records);
        assert_eq!((runs[0].ratio_median, runs[1].ratio_median), (1.0, 2.0));
        assert_eq!((runs[1].ratio_p95, runs[1].ms.worst), (1.5, 9.0));
        assert_eq!((runs[0].ratio_uniform, runs[0].ratio_cold), (Some(0.5), None));
        assert_eq!(runs[0].ratio_map_lookup, Some(Ratios { median: 2.0, p95: 3.0 }));
        assert!(runs[0].pages.0.is_empty() && runs[0].crawl.is_none());
    }

    #[test]
    fn frames_that_put_something_off_are_told_apart() {
        let mut frames = vec![record(1.0); 4];
        assert!(ColdSummary::of(&frames).is_none());
        for (frame, (deferred, pixels)) in frames.iter_mut().zip([(0, 0), (3, 70), (0, 2)]) {
            frame.counters = vec![("pages_deferred", deferred)];
            frame.differing = Some(pixels);
        }
        let sum = ColdSummary::of(&frames).unwrap();
        assert_eq!((sum.whole_frames, sum.differing_pixels), (2, 2));
        assert_eq!((sum.put_off_frames, sum.put_off_differing_pixels), (1, 70));
    }

    #[test]
    fn crawl_is_summed_up() {
        let mut frames = vec![record(1.0); 3];
        assert!(CrawlSummary::of(&frames).is_none());
        for (frame, flips) in frames.iter_mut().zip([1.0, 2.0, 6.0]) {
            frame.crawl = Some(Crawl { flips, reference_flips: 1.0, crawl: flips - 1.0, decided_pixels: 9 });
        }
        let sum = CrawlSummary::of(&frames).unwrap();
        assert_eq!((sum.flips, sum.reference_flips, sum.ratio, sum.crawl), (2.0, 1.0, Some(3.0), 1.0));
    }

    fn record(ms: f64) -> Record {
        let times = umbrage::methods::FrameTimes { ms, ..Default::default() };
        Record { times, ..Record::default() }
    }
}
