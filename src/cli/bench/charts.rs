//! The plots of a run: time, pages and error by frame.

use super::record::Record;
use crate::cli::failure::Failure;
use std::path::Path;
use umbrage::methods::MethodSpec;
use umbrage::output::{Chart, Line, write_svg};

/// The page counters that are plotted, and what the legend calls them.
const PAGES: [(&str, &str); 3] =
    [("pages_requested", "requested"), ("pages_drawn", "drawn"), ("pages_deferred", "deferred")];

/// Writes `time.svg`, and where there is something to show `pages.svg` and `error.svg`.
pub fn write(at: &Path, caption: &str, specs: &[MethodSpec], records: &[Vec<Record>]) -> Result<(), Failure> {
    let runs = || specs.iter().zip(records);
    let times = runs().map(|(spec, run)| line(spec.text.clone(), run, |record| Some(record.times.ms)));
    let pages = runs().flat_map(|(spec, run)| {
        PAGES.iter().map(move |(counter, label)| {
            line(format!("{}: {label}", spec.text), run, |record| record.counter(counter).map(|n| n as f64))
        })
    });
    let errors =
        runs().map(|(spec, run)| line(spec.text.clone(), run, |record| record.errors.as_ref().map(|e| e.all.mismatch)));
    let charts = [
        ("time.svg", "Time per frame", "ms after the depth prepass", times.collect::<Vec<_>>()),
        ("pages.svg", "Pages per frame", "pages", pages.collect()),
        ("error.svg", "Error per frame", "mismatch in % of decided pixels", errors.collect()),
    ];
    for (file, title, y_label, mut lines) in charts {
        lines.retain(|line| !line.points.is_empty());
        if !lines.is_empty() {
            let title = format!("{title}: {caption}");
            let chart =
                Chart { title: &title, x_label: "frame (60 a second)", y_label, lines: &lines, ..Chart::default() };
            write_svg(&at.join(file), &chart)?;
        }
    }
    Ok(())
}

fn line(label: String, run: &[Record], value: impl Fn(&Record) -> Option<f64>) -> Line {
    let point = |(frame, record): (usize, &Record)| Some((frame as f64, value(record)?));
    Line { label, points: run.iter().enumerate().filter_map(point).collect(), notes: Vec::new() }
}
