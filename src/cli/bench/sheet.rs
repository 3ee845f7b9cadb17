//! `bench.csv` and the table that is printed.

use super::json::Run;
use super::record::{PAGES, Record};
use super::schedule::Schedule;
use crate::cli::print;
use umbrage::methods::MethodSpec;

/// Columns after the stages and the page counters.
const MEASURED: [&str; 10] =
    ["bytes", "mismatch", "edge_error", "off_edge", "acne", "leak", "lost", "flips", "reference_flips", "crawl"];

/// One line for each frame of each method. What a method does not have or a frame did not measure is empty; times are
/// in milliseconds, errors in percent.
pub fn csv(specs: &[MethodSpec], records: &[Vec<Record>], schedule: &Schedule) -> String {
    let mut stages: Vec<&str> = Vec::new();
    for (name, _) in records.iter().flatten().flat_map(|record| &record.times.stages) {
        if !stages.contains(name) {
            stages.push(name);
        }
    }
    let header = ["frame", "time_s", "method", "ms", "prepass_ms", "wall_ms"].map(str::to_owned).into_iter();
    let stage_columns = stages.iter().map(|stage| format!("{stage}_ms"));
    let others = PAGES.into_iter().chain(MEASURED).map(str::to_owned);
    let mut text = header.chain(stage_columns).chain(others).collect::<Vec<_>>().join(",") + "\n";
    for frame in 0..records.iter().map(Vec::len).max().unwrap_or(0) {
        for (spec, record) in specs.iter().zip(records).filter_map(|(s, r)| Some((s, r.get(frame)?))) {
            let time_s = schedule.time_s(frame as u32);
            text += &format!("{frame},{time_s:.6},{},{}\n", quoted(&spec.text), cells(record, &stages).join(","));
        }
    }
    text
}

fn cells(record: &Record, stages: &[&str]) -> Vec<String> {
    let times = &record.times;
    let stage = |name: &&str| times.stages.iter().filter(|s| s.0 == *name).map(|s| s.1).reduce(|a, b| a + b);
    let ms = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:.4}"));
    let percent = |value: Option<f64>| value.filter(|v| v.is_finite()).map_or(String::new(), |v| format!("{v:.6}"));
    let count = |value: Option<u64>| value.map_or(String::new(), |value| value.to_string());
    let (e, c) = (record.errors.as_ref().map(|e| e.all), record.crawl);
    let errors = [
        e.map(|e| e.mismatch),
        e.map(|e| e.edge_error),
        e.map(|e| e.off_edge),
        e.map(|e| e.acne),
        e.map(|e| e.leak),
        e.map(|e| e.lost),
        c.map(|c| c.flips),
        c.map(|c| c.reference_flips),
        c.map(|c| c.crawl),
    ];
    let whole = [times.ms, times.prepass_ms, times.wall_ms].into_iter().map(Some);
    let times = whole.chain(stages.iter().map(stage)).map(ms);
    let counts = PAGES.map(|name| record.counter(name)).into_iter().chain([Some(record.bytes)]).map(count);
    times.chain(counts).chain(errors.map(percent)).collect()
}

/// A cell of a CSV file that may hold commas.
fn quoted(text: &str) -> String {
    if text.contains([',', '"']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

/// One row a method; columns that no method fills are left out.
pub fn table(runs: &[Run]) -> String {
    let number = |value: Option<f64>, digits: usize| value.map_or("-".to_owned(), |v| format!("{v:.digits$}"));
    let row = |run: &Run| {
        let drawn = run.pages.0.iter().find(|(name, _)| *name == "pages_drawn").map(|(_, tail)| *tail);
        vec![
            run.method.to_owned(),
            number(Some(run.ms.median), 2),
            number(Some(run.ms.p95), 2),
            number(Some(run.ms.worst), 2),
            number(Some(run.ratio_median), 2),
            number(Some(run.ratio_p95), 2),
            number(run.ratio_uniform, 2),
            number(run.ratio_map_lookup.map(|r| r.median), 2),
            number(run.ratio_map_lookup.map(|r| r.p95), 2),
            number(run.ratio_cold, 2),
            number(drawn.map(|d| d.median), 0),
            number(drawn.map(|d| d.worst), 0),
            number(Some(print::mib(run.bytes)), 1),
            number(run.mismatch.map(|m| m.median), 4),
            number(run.crawl.as_ref().map(|c| c.crawl), 4),
            run.cold.as_ref().map_or("-".to_owned(), |c| c.differing_pixels.to_string()),
        ]
    };
    let header = [
        "method",
        "ms",
        "p95",
        "worst",
        "ratio",
        "ratio p95",
        "/uniform",
        "/map+lookup",
        "p95",
        "/cold",
        "drawn",
        "drawn worst",
        "MiB",
        "mismatch %",
        "crawl %",
        "px off cold",
    ];
    let mut rows = vec![header.map(str::to_owned).to_vec()];
    rows.extend(runs.iter().map(row));
    let filled: Vec<bool> = (0..header.len()).map(|c| rows[1..].iter().any(|row| row[c] != "-")).collect();
    for row in &mut rows {
        let mut keep = filled.iter();
        row.retain(|_| keep.next().is_some_and(|&keep| keep));
    }
    print::table(&rows, 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage::methods::FrameTimes;

    #[test]
    fn cells_stay_in_their_columns() {
        let times = FrameTimes { ms: 3.0, stages: vec![("b", 1.0), ("a", 2.0)], ..FrameTimes::default() };
        let record = Record { times, counters: vec![("pages_drawn", 7)], bytes: 9, ..Record::default() };
        let text = cells(&record, &["a", "c", "b"]).join(",");
        assert_eq!(text, "3.0000,0.0000,0.0000,2.0000,,1.0000,,,7,,,9,,,,,,,,,");
    }

    #[test]
    fn commas_are_quoted() {
        assert_eq!(quoted("rmsm"), "rmsm");
        assert_eq!(quoted("rmsm:a=1,b=2"), "\"rmsm:a=1,b=2\"");
    }
}
