//! `umbrage compare`: several methods by turns on one view.

use super::args::CompareArgs;
use super::failure::Failure;
use super::folder::Folder;
use super::measure;
use super::pictures;
use super::print;
use super::progress::Progress;
use super::report::{Comparison, LightErrors, Row, write_json};
use super::setup;
use super::sweep;
use std::rc::Rc;
use umbrage::lab::Lab;
use umbrage::methods;
use umbrage::output::{Picture, side_by_side, write_png};
use umbrage::truth::{CoverageError, Reference, TruthError, compare_coverage};

const HEADER: [&str; 8] = ["method", "ms", "ratio", "MiB", "mismatch %", "edge_error %", "off_edge %", "lost %"];

const COVERAGE: [&str; 2] = ["coverage %", "on edges %"];

/// Most runs of a sweep in `comparison.png`.
const MOST_PICTURES: usize = 8;

/// Runs, compares and writes the results.
pub fn run(args: &CompareArgs) -> Result<(), Failure> {
    let common = &args.common;
    let variants = sweep::variants(&args.methods.0, args.sweep.as_ref())?;
    let folder = Folder::open(&args.out)?;
    let progress = Progress::new(common.quiet);
    let lab = setup::open(common, &progress)?;
    let mut methods =
        variants.iter().map(|variant| methods::create(&variant.spec, &lab)).collect::<Result<Vec<_>, _>>()?;
    let bar = progress.bar("running the methods");
    let timings = measure::by_turns(&lab, &mut methods, args.rounds, |share| bar.at(share))?;
    drop(bar);

    let references = setup::references(&lab, &progress)?;
    let coverages = args.coverage.map(|samples| setup::coverages(&lab, samples, &progress)).transpose()?;
    let gbuffer = lab.gbuffer()?;
    let mut rows: Vec<Row> = Vec::new();
    let mut images: Vec<(&str, Picture)> = Vec::new();
    let mut differences: Vec<(&str, Picture)> = Vec::new();
    let pictured = pictured(variants.len(), args.sweep.is_some());
    for (i, ((variant, method), timings)) in variants.iter().zip(&mut methods).zip(&timings).enumerate() {
        let visibility = measure::visibility(&lab, method.as_mut())?;
        let errors = LightErrors::of(&visibility, &references)?;
        let coverage = coverages.as_ref().map(|traced| coverage(&visibility, traced, &references)).transpose()?;
        let mut row = Row { coverage, ..Row::new(variant, timings, &method.memory(), errors) };
        row.ratio = row.ms.median / rows.first().unwrap_or(&row).ms.median;
        rows.push(row);
        if pictured.contains(&i) {
            images.push((&variant.spec.text, pictures::shaded(&lab, &gbuffer, &visibility)?));
            differences
                .push(("difference from ray tracing", pictures::difference(&lab, &gbuffer, &visibility, &references)?));
        }
    }
    let tiles: Vec<_> = images.iter().chain(&differences).map(|(label, picture)| (*label, picture)).collect();
    setup::validated(&lab)?;
    let side_by_side = side_by_side(&tiles, images.len());
    let scene = common.scene.to_string_lossy();
    let sweep = args.sweep.as_ref();
    let comparison =
        Comparison { device: lab.device_name(), driver: lab.driver(), scene: &scene, view: lab.view(), sweep, rows };
    let caption = format!("{}, {}", lab.scene().name, setup::place(&lab));

    folder.fill(|at| {
        write_png(&at.join("comparison.png"), &side_by_side)?;
        write_json(&at.join("view.json"), lab.view())?;
        write_json(&at.join("compare.json"), &comparison)?;
        sweep.map_or(Ok(()), |sweep| sweep::write_charts(at, &caption, sweep, &comparison.rows))
    })?;
    if !common.quiet {
        print::out(&table(&comparison.rows));
        print::out(&by_light(&comparison.rows));
        print::out(&footer(&lab, &format!("{} rounds by turns", args.rounds)));
        print::out(&format!("results are in {}\n", args.out.display()));
    }
    Ok(())
}

/// The runs that are shown: all, but of a sweep at most a few at equal distances.
fn pictured(runs: usize, sweep: bool) -> Vec<usize> {
    let shown = if sweep { runs.min(MOST_PICTURES) } else { runs };
    (0..shown).map(|k| k * (runs - 1) / (shown - 1).max(1)).collect()
}

/// Errors over all lights together.
fn coverage(
    visibility: &[Vec<f32>],
    traced: &[Vec<f32>],
    references: &[Rc<Reference>],
) -> Result<CoverageError, TruthError> {
    let lights = visibility.iter().zip(traced).zip(references);
    lights.map(|((image, traced), reference)| compare_coverage(image, traced, reference)).sum()
}

fn table(rows: &[Row]) -> String {
    let cells = |row: &Row| {
        let e = &row.errors.all;
        let mut cells = vec![
            row.method.to_owned(),
            format!("{:.2}", row.ms.median),
            format!("{:.2}", row.ratio),
            format!("{:.1}", print::mib(row.bytes)),
            format!("{:.4}", e.mismatch),
            format!("{:.2}", e.edge_error),
            format!("{:.4}", e.off_edge),
            format!("{:.4}", e.lost),
        ];
        cells.extend(row.coverage.iter().flat_map(|c| [format!("{:.4}", c.mean), format!("{:.2}", c.edge)]));
        cells
    };
    let mut header = HEADER.map(str::to_owned).to_vec();
    if rows.iter().any(|row| row.coverage.is_some()) {
        header.extend(COVERAGE.map(str::to_owned));
    }
    print::table(&std::iter::once(header).chain(rows.iter().map(cells)).collect::<Vec<_>>(), 1)
}

/// The errors of each light, where there are several.
fn by_light(rows: &[Row]) -> String {
    let lights = rows.first().map_or(0, |row| row.errors.lights.len());
    if lights < 2 {
        return String::new();
    }
    let header = ["method", "light", "mismatch %", "edge_error %", "off_edge %", "lost %"].map(str::to_owned).to_vec();
    let cells = rows.iter().flat_map(|row| {
        row.errors.lights.iter().enumerate().map(|(light, e)| {
            vec![
                row.method.to_owned(),
                light.to_string(),
                format!("{:.4}", e.mismatch),
                format!("{:.2}", e.edge_error),
                format!("{:.4}", e.off_edge),
                format!("{:.4}", e.lost),
            ]
        })
    });
    print::table(&std::iter::once(header).chain(cells).collect::<Vec<_>>(), 1)
}

/// What the printed times are; `of` says what they are the median of.
pub fn footer(lab: &Lab, of: &str) -> String {
    let (name, driver) = (lab.device_name(), lab.driver());
    let mut text = format!("ms: median of {of}, after the depth prepass, on {name} ({driver})\n");
    if lab.device_is_cpu() {
        text +=
            "This device is software on the CPU (lavapipe): compare its ratios, its times are not those of a GPU.\n";
    }
    text
}

#[cfg(test)]
mod tests {
    use super::pictured;

    #[test]
    fn pictures_of_a_sweep_are_few() {
        assert_eq!([pictured(1, true), pictured(3, true)], [vec![0], vec![0, 1, 2]]);
        assert_eq!(pictured(22, true), [0, 3, 6, 9, 12, 15, 18, 21]);
        assert_eq!(pictured(22, false).len(), 22);
    }
}
