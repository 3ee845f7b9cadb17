//! Runs the frames: each step shows one view to all methods.

use super::record::{Record, cold};
use super::schedule::Schedule;
use crate::cli::failure::Failure;
use crate::cli::measure;
use crate::cli::results::LightErrors;
use std::rc::Rc;
use umbrage::lab::{Lab, LabError};
use umbrage::methods::{Method, MethodSpec};
use umbrage::truth::{self, Reference};

/// What the next frame is compared with.
#[derive(Default)]
struct Before {
    /// Step and the reference of each light.
    references: Option<(u32, Vec<Rc<Reference>>)>,
    /// Visibility of each method at that step, by light.
    visibility: Vec<Vec<Vec<f32>>>,
}

/// All frames of every method; the first to run changes from frame to frame. `share` is told how much is done.
pub fn run(
    lab: &mut Lab,
    methods: &mut [Box<dyn Method>],
    specs: &[MethodSpec],
    schedule: &Schedule,
    truth_every: u32,
    share: impl Fn(f64),
) -> Result<Vec<Vec<Record>>, Failure> {
    let cold: Vec<Option<usize>> = specs.iter().map(|spec| cold(specs, spec)).collect();
    let mut runs: Vec<Vec<Record>> = vec![Vec::new(); methods.len()];
    let mut before = Before { references: None, visibility: vec![Vec::new(); methods.len()] };
    for step in 0..schedule.steps() {
        let Some(view) = schedule.view(step) else { break };
        lab.animate(view.time_s)?;
        lab.look(view)?;
        for turn in 0..methods.len() {
            let m = (turn + step as usize) % methods.len();
            let record = one(lab, methods[m].as_mut())?;
            if Schedule::frame(step).is_some() {
                runs[m].push(record);
            }
        }
        let frame = Schedule::frame(step);
        if frame.is_some_and(|frame| truth_every > 0 && frame % truth_every == 0) {
            judge(lab, methods, step, &mut before, &mut runs)?;
            against_cold(&before, &cold, &mut runs);
        }
        share(f64::from(step + 1) / f64::from(schedule.steps()));
    }
    Ok(runs)
}

fn one(lab: &Lab, method: &mut dyn Method) -> Result<Record, LabError> {
    let times = method.frame(lab)?;
    let counters = method.statistics(lab)?.counters;
    let bytes = method.memory().iter().map(|(_, bytes)| bytes).sum();
    Ok(Record { times, counters, bytes, errors: None, crawl: None, differing: None, cold_put_off: false })
}

/// Compares each method's last frame with the reference, and with the frame before where that was measured too.
fn judge(
    lab: &Lab,
    methods: &mut [Box<dyn Method>],
    step: u32,
    before: &mut Before,
    runs: &mut [Vec<Record>],
) -> Result<(), Failure> {
    let lights = 0..lab.view().lights.len();
    let references = lights.map(|light| lab.reference(light, &|_| {})).collect::<Result<Vec<_>, _>>()?;
    let last = before.references.take().filter(|(at, _)| at + 1 == step);
    for ((method, run), old) in methods.iter_mut().zip(runs).zip(&mut before.visibility) {
        let visibility = measure::visibility(lab, method.as_mut())?;
        if let Some(record) = run.last_mut() {
            record.errors = Some(LightErrors::of(&visibility, &references)?);
            if let Some((_, last)) = &last {
                let frames = (old.iter().zip(last)).zip(visibility.iter().zip(&references));
                let crawl = frames.map(|((a, before), (b, now))| truth::crawl((a, before), (b, now)));
                record.crawl = Some(crawl.collect::<Result<Vec<_>, _>>()?.into_iter().sum());
            }
        }
        *old = visibility;
    }
    before.references = Some((step, references));
    Ok(())
}

/// Compares each method's last frame with that of the same method without its cache, bit for bit.
fn against_cold(shown: &Before, cold: &[Option<usize>], runs: &mut [Vec<Record>]) {
    let cold_put_off: Vec<bool> = runs.iter().map(|run| run.last().is_some_and(Record::put_off)).collect();
    for (m, (run, cold)) in runs.iter_mut().zip(cold).enumerate() {
        if let (Some(record), Some(cold)) = (run.last_mut(), cold.filter(|&cold| cold != m)) {
            let pairs = shown.visibility[m].iter().flatten().zip(shown.visibility[cold].iter().flatten());
            record.differing = Some(pairs.filter(|(a, b)| a.to_bits() != b.to_bits()).count() as u64);
            record.cold_put_off = cold_put_off[cold];
        }
    }
}
