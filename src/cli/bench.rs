//! `umbrage bench`: several methods by turns over the frames of a camera path.

mod charts;
mod drive;
mod json;
mod record;
mod schedule;
mod sheet;

use super::args::{BenchArgs, PathChoice};
use super::compare;
use super::failure::Failure;
use super::folder::Folder;
use super::print;
use super::progress::Progress;
use super::results::write_json;
use super::setup::{self, Movement};
use json::{Bench, Run};
use schedule::Schedule;
use std::path::Path;
use umbrage::methods;
use umbrage::output::write_file;
use umbrage::view::{CameraPath, PathFile};

/// Runs the frames and writes the results.
pub fn run(args: &BenchArgs) -> Result<(), Failure> {
    let common = &args.common;
    let specs = &args.methods.0;
    let folder = Folder::open(&args.out)?;
    let (path, path_name) = match &args.path {
        PathChoice::Named(path) => (path.clone(), format!("{path:?}").to_lowercase()),
        PathChoice::File(file) => (CameraPath::Keys(PathFile::read(file)?), file.to_string_lossy().into_owned()),
    };
    let progress = Progress::new(common.quiet);
    let animate = args.animate || args.movers.is_some_and(|count| count > 0);
    let movement = Movement { animate, movers: args.movers, seed: args.seed, copies: args.copies };
    let mut lab = setup::open_moving(common, movement, &progress)?;
    let schedule = Schedule::new(&lab, &path, args)?;
    let mut methods = specs.iter().map(|spec| methods::create(spec, &lab)).collect::<Result<Vec<_>, _>>()?;
    let bar = progress.bar("running the frames");
    let records = drive::run(&mut lab, &mut methods, specs, &schedule, args.truth_every, |share| bar.at(share))?;
    drop(bar);
    setup::validated(&lab)?;

    let bench = Bench {
        device: lab.device_name(),
        driver: lab.driver(),
        scene: &common.scene.to_string_lossy(),
        path: &path_name,
        view: schedule.base(),
        animate,
        movers: args.movers,
        copies: args.copies,
        sun_rate_deg_per_s: args.sun_rate,
        truth_every: args.truth_every,
        seed: args.seed,
        runs: Run::of(specs, &records),
    };
    let caption = format!("{}, path {path_name}, {}", lab.scene().name, setup::place(&lab));
    folder.fill(|at| {
        write_file(&at.join("bench.json"), json::text(&bench)?.as_bytes())?;
        write_file(&at.join("bench.csv"), sheet::csv(specs, &records, &schedule).as_bytes())?;
        write_json(&at.join("view.json"), schedule.base())?;
        charts::write(at, &caption, specs, &records)
    })?;
    if !common.quiet {
        print::out(&sheet::table(&bench.runs));
        let what = format!("{} frames of path {path_name} by turns", args.frames);
        print::out(&compare::footer(&lab, &what));
        print::out(&where_it_is(&args.out));
    }
    Ok(())
}

fn where_it_is(out: &Path) -> String {
    format!("results are in {}\n", out.display())
}
