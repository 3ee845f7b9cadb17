//! The plots of a sweep: error against memory, time and value, and time against value.

use super::{Sweep, number};
use crate::cli::failure::Failure;
use crate::cli::print;
use crate::cli::results::Row;
use umbrage::output::{Chart, Line, Scale, draw_svg};

const ERROR: &str = "mismatch in % of decided pixels";
const TIME: &str = "ms after the depth prepass";

/// A plot and the name of its file.
#[derive(Debug)]
pub struct Plot {
    pub file: String,
    pub svg: String,
}

/// Draws `sweep_error_value.svg`, `sweep_time_value.svg`, `sweep_error_time.svg` and, where the value changes the memory,
/// `sweep_error_bytes.svg`; none where the values are words.
pub fn draw(caption: &str, sweep: &Sweep, rows: &[Row]) -> Result<Vec<Plot>, Failure> {
    let Some(values) = sweep.numbers() else { return Ok(Vec::new()) };
    let rows = &ordered(rows);
    let ends = values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], &v| [a.min(v), b.max(v)]);
    let (bytes, error, time) =
        (|row: &Row| print::mib(row.bytes), |row: &Row| row.errors.all.mismatch, |row: &Row| row.ms.median);
    let charts = [
        ("error_value", "Error", sweep.key.as_str(), ERROR, against_value(rows, ends, error)),
        ("time_value", "Time", sweep.key.as_str(), TIME, against_value(rows, ends, time)),
        ("error_time", "Error against time", TIME, ERROR, against(rows, time, error)),
        ("error_bytes", "Error against memory", "MiB of device memory", ERROR, against(rows, bytes, error)),
    ];
    let mut plots = Vec::new();
    for (file, title, x_label, y_label, lines) in charts {
        let points = || lines.iter().flat_map(|line| &line.points);
        if lines.iter().all(|line| line.points.iter().all(|point| point.0 == line.points[0].0)) {
            continue;
        }
        let title = format!("{title}, {} swept: {caption}", sweep.key);
        let (x_scale, y_scale) = (Scale::fitting(points().map(|p| p.0)), Scale::fitting(points().map(|p| p.1)));
        let chart = Chart { title: &title, x_label, y_label, x_scale, y_scale, lines: &lines };
        plots.push(Plot { file: format!("sweep_{file}.svg"), svg: draw_svg(&chart)? });
    }
    Ok(plots)
}

/// The runs of a method by value, in the place of its first.
fn ordered<'a, 'b>(rows: &'b [Row<'a>]) -> Vec<&'b Row<'a>> {
    let mut rows: Vec<_> = rows.iter().collect();
    for runs in rows.chunk_by_mut(|a, b| a.swept.map(|s| &s.of) == b.swept.map(|s| &s.of)) {
        runs.sort_by(|a, b| value(a).partial_cmp(&value(b)).unwrap_or(std::cmp::Ordering::Equal));
    }
    rows
}

/// The runs of each method against the values; a method that does not know the key is the same for all of them.
fn against_value(rows: &[&Row], ends: [f64; 2], y: impl Fn(&Row) -> f64) -> Vec<Line> {
    let mut lines = lines(rows, |row| match value(row) {
        Some(value) => vec![(value, y(row))],
        None => ends.map(|value| (value, y(row))).to_vec(),
    });
    // the axis says it
    lines.iter_mut().for_each(|line| line.notes.clear());
    lines
}

/// The runs of each method, each with its value beside it.
fn against(rows: &[&Row], x: impl Fn(&Row) -> f64, y: impl Fn(&Row) -> f64) -> Vec<Line> {
    lines(rows, |row| vec![(x(row), y(row))])
}

fn value(row: &Row) -> Option<f64> {
    row.swept.and_then(|swept| number(&swept.value))
}

/// A line for each method, in the order of `rows`.
fn lines(rows: &[&Row], points: impl Fn(&Row) -> Vec<(f64, f64)>) -> Vec<Line> {
    let mut lines: Vec<Line> = Vec::new();
    for row in rows {
        let label = row.swept.map_or(row.method, |swept| &swept.of);
        let note = row.swept.map_or(String::new(), |swept| swept.value.clone());
        let at = lines.iter().position(|line| line.label == label).unwrap_or(lines.len());
        if at == lines.len() {
            lines.push(Line { label: label.to_owned(), ..Line::default() });
        }
        lines[at].points.extend(points(row));
        lines[at].notes.push(note);
    }
    lines
}
