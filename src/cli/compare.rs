//! `umbrage compare`: several methods by turns on one view.

use super::args::CompareArgs;
use super::failure::Failure;
use super::figures::{self, Figure};
use super::folder::Folder;
use super::measure;
use super::pictures;
use super::print;
use super::progress::Progress;
use super::report::{self, Report, Shot};
use super::results::{Comparison, LightErrors, Row, SamplingErrors, write_json};
use super::setup;
use super::sweep;
use std::rc::Rc;
use umbrage::lab::Lab;
use umbrage::methods;
use umbrage::output::{side_by_side, write_file, write_png};
use umbrage::truth::{CoverageError, Reference, TruthError, compare_coverage};

/// Most runs of a sweep in `comparison.png` and `report.html`.
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
    let mut shots: Vec<Shot> = Vec::new();
    let pictured = pictured(variants.len(), args.sweep.is_some());
    for (i, ((variant, method), timings)) in variants.iter().zip(&mut methods).zip(&timings).enumerate() {
        let visibility = measure::visibility(&lab, method.as_mut())?;
        let errors = LightErrors::of(&visibility, &references)?;
        let coverage = coverages.as_ref().map(|traced| coverage(&visibility, traced, &references)).transpose()?;
        let sampling = measure::sampling(&lab, method.as_mut())?.iter().map(SamplingErrors::of).collect();
        let mut row = Row { coverage, sampling, ..Row::new(variant, timings, &method.memory(), errors) };
        row.ratio = row.ms.median / rows.first().unwrap_or(&row).ms.median;
        rows.push(row);
        if pictured.contains(&i) {
            shots.push(Shot {
                method: &variant.spec.text,
                picture: pictures::shaded(&lab, &gbuffer, &visibility)?,
                difference: pictures::difference(&lab, &gbuffer, &visibility, &references)?,
            });
        }
    }
    setup::validated(&lab)?;
    let images = shots.iter().map(|shot| (shot.method, &shot.picture));
    let differences = shots.iter().map(|shot| ("difference from ray tracing", &shot.difference));
    let side_by_side = side_by_side(&images.chain(differences).collect::<Vec<_>>(), shots.len());
    let scene = common.scene.to_string_lossy();
    let sweep = args.sweep.as_ref();
    let comparison =
        Comparison { device: lab.device_name(), driver: lab.driver(), scene: &scene, view: lab.view(), sweep, rows };
    let caption = format!("{}, {}", lab.scene().name, setup::place(&lab));
    let plots = sweep.map_or(Ok(Vec::new()), |sweep| sweep::plots(&caption, sweep, &comparison.rows))?;
    let times = footer(&lab, &format!("{} rounds by turns", args.rounds));
    let page = report::page(&Report {
        comparison: &comparison,
        specs: &variants.iter().map(|variant| &variant.spec).collect::<Vec<_>>(),
        times: &times,
        reference: &pictures::traced(&lab, &gbuffer, &references)?,
        shots: &shots,
        plots: &plots,
        command: &report::this_command(),
    })?;

    folder.fill(|at| {
        write_png(&at.join("comparison.png"), &side_by_side)?;
        write_json(&at.join("view.json"), lab.view())?;
        write_json(&at.join("compare.json"), &comparison)?;
        for plot in &plots {
            write_file(&at.join(&plot.file), plot.svg.as_bytes())?;
        }
        Ok(write_file(&at.join("report.html"), page.as_bytes())?)
    })?;
    if !common.quiet {
        print::out(&table(&comparison.rows));
        print::out(&by_light(&comparison.rows));
        print::out(&times);
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
    lined_up(&["method"], rows.iter().map(|row| (vec![row.method.to_owned()], figures::of_row(row))))
}

/// The errors of each light, where there are several.
fn by_light(rows: &[Row]) -> String {
    let lights = |row: &Row| row.errors.lights.len();
    if rows.first().map_or(0, lights) < 2 {
        return String::new();
    }
    let rows = rows.iter().flat_map(|row| {
        let errors = row.errors.lights.iter().enumerate();
        errors.map(|(light, e)| (vec![row.method.to_owned(), light.to_string()], figures::of_errors(e)))
    });
    lined_up(&["method", "light"], rows)
}

/// Rows of first cells and figures below their names.
fn lined_up(first: &[&str], rows: impl Iterator<Item = (Vec<String>, Vec<Figure>)>) -> String {
    let rows: Vec<_> = rows.collect();
    let names = rows.first().into_iter().flat_map(|(_, figures)| figures.iter().map(|figure| figure.column.name));
    let header = first.iter().copied().chain(names).map(str::to_owned).collect();
    let cells =
        rows.iter().map(|(cells, figures)| cells.iter().cloned().chain(figures.iter().map(Figure::text)).collect());
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
