//! Turns the `compare.json` files of `tools/measure` into one table: errors of each method, costs of `rmsm`.

use serde_json::Value;
use std::collections::BTreeMap;
use std::process::ExitCode;

const METRICS: [&str; 4] = ["mismatch", "edge_error", "off_edge", "lost"];

fn main() -> ExitCode {
    match tables(std::env::args().skip(1)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(what) => {
            eprintln!("error: {what}");
            ExitCode::FAILURE
        }
    }
}

fn tables(files: impl Iterator<Item = String>) -> Result<(), String> {
    let mut errors: BTreeMap<(usize, String), Vec<[f64; 4]>> = BTreeMap::new();
    let mut costs: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    println!("{:<32} mismatch % of each method", "view");
    for file in files {
        let text = std::fs::read_to_string(&file).map_err(|e| format!("{file}: {e}"))?;
        let json: Value = serde_json::from_str(&text).map_err(|e| format!("{file}: {e}"))?;
        let rows = json["rows"].as_array().ok_or_else(|| format!("{file}: no rows"))?;
        let name = file.rsplit('/').nth(1).unwrap_or(&file);
        let mismatch: Vec<_> = rows.iter().map(|r| format!("{:8.4}", number(&r["mismatch"]))).collect();
        println!("{name:<32} {}", mismatch.join(" "));
        for (i, row) in rows.iter().enumerate() {
            let key = (i, row["method"].as_str().unwrap_or_default().to_owned());
            errors.entry(key).or_default().push(METRICS.map(|m| number(&row[m])));
        }
        cost_ratios(rows, &mut costs);
    }
    println!("\n{:<28} median / worst over the views, in percent", "");
    println!("{:<28} {}", "method", METRICS.map(|m| format!("{m:>17}")).join(" "));
    for ((_, method), rows) in &errors {
        let column = |m: usize| {
            let values: Vec<_> = rows.iter().map(|r| r[m]).collect();
            format!("{:>17}", format!("{:.4} / {:.4}", median(&values), values.iter().copied().fold(0.0, f64::max)))
        };
        println!("{method:<28} {}", [0, 1, 2, 3].map(column).join(" "));
    }
    println!("\ncosts as ratios inside each run: median (least to most) over the views");
    for (what, values) in &costs {
        let (low, high) = values.iter().fold((f64::INFINITY, 0.0f64), |(l, h), v| (l.min(*v), h.max(*v)));
        println!("{what:<66} {:.2} ({low:.2} to {high:.2})", median(values));
    }
    Ok(())
}

/// Costs of the first row (rmsm, flags) and the second (rmsm, sort) against the third (uniform 4096).
fn cost_ratios(rows: &[Value], costs: &mut BTreeMap<&str, Vec<f64>>) {
    let [flags, sort, uniform, ..] = rows else { return };
    let stage = |row: &Value, names: &[&str]| names.iter().map(|n| number(&row["stages"][n])).sum::<f64>();
    let map = stage(uniform, &["map"]);
    let lookup = stage(uniform, &["lookup"]);
    let front = ["reset", "gradient", "request", "sort", "compact", "cache", "allocate"];
    for (what, ratio) in [
        ("requests to allocation (gradient too), flags / uniform map", stage(flags, &front) / map),
        ("requests to allocation (gradient too), sort / uniform map", stage(sort, &front) / map),
        ("cold tiles with culling / uniform map", stage(flags, &["cull", "tiles"]) / map),
        ("lookup / uniform lookup", stage(flags, &["lookup"]) / lookup),
        ("whole frame / uniform frame", number(&flags["ms"]["median"]) / number(&uniform["ms"]["median"])),
        ("whole frame, sort / flags", number(&sort["ms"]["median"]) / number(&flags["ms"]["median"])),
    ] {
        costs.entry(what).or_default().push(ratio);
    }
}

/// 0 for null, which stands for an edge error without edges.
fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(0.0)
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    match sorted.len() {
        0 => 0.0,
        n if n % 2 == 1 => sorted[n / 2],
        n => 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]),
    }
}
