//! Times of methods that run by turns.

use serde::Serialize;
use umbrage::lab::{Lab, LabError};
use umbrage::methods::{FrameTimes, Method};

/// Frames of each method before the timed ones; the first of them is the cold one.
const WARM_UP: u32 = 3;

/// Least, middle and greatest of some values.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    pub min: f64,
    pub median: f64,
    pub max: f64,
}

impl Spread {
    /// All zero where there are no values.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> = values.into_iter().collect();
        sorted.sort_by(f64::total_cmp);
        let at = |index: usize| sorted.get(index).copied().unwrap_or(0.0);
        let last = sorted.len().saturating_sub(1);
        Self { min: at(0), median: 0.5 * (at(last / 2) + at(last.div_ceil(2))), max: at(last) }
    }
}

/// The frames of one method.
#[derive(Debug, Clone, Default)]
pub struct Timings {
    /// The very first frame.
    pub cold: FrameTimes,
    /// The timed frames.
    frames: Vec<FrameTimes>,
}

impl Timings {
    /// Number of timed frames.
    pub fn count(&self) -> u32 {
        self.frames.len() as u32
    }

    /// What one frame's time is over all timed frames.
    pub fn spread(&self, time: impl Fn(&FrameTimes) -> f64) -> Spread {
        Spread::of(self.frames.iter().map(time))
    }

    /// The stages in order.
    pub fn stages(&self) -> Vec<(&'static str, Spread)> {
        let names = self.frames.first().into_iter().flat_map(|frame| frame.stages.iter().map(|&(name, _)| name));
        let times =
            |name| self.frames.iter().flat_map(move |f| f.stages.iter().filter(move |s| s.0 == name).map(|s| s.1));
        names.map(|name| (name, Spread::of(times(name)))).collect()
    }
}

/// Runs every method once a round; `share` is told how much is done.
pub fn by_turns(
    lab: &Lab,
    methods: &mut [Box<dyn Method>],
    rounds: u32,
    share: impl Fn(f64),
) -> Result<Vec<Timings>, LabError> {
    let mut timings = vec![Timings::default(); methods.len()];
    let mut done = 0.0;
    let all = f64::from(WARM_UP + rounds) * methods.len() as f64;
    for round in 0..WARM_UP + rounds {
        for (method, timings) in methods.iter_mut().zip(&mut timings) {
            let frame = method.frame(lab)?;
            match round {
                0 => timings.cold = frame,
                _ if round < WARM_UP => {}
                _ => timings.frames.push(frame),
            }
            done += 1.0;
            share(done / all);
        }
    }
    Ok(timings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spreads() {
        assert_eq!(Spread::of([3.0, 1.0, 2.0]), Spread { min: 1.0, median: 2.0, max: 3.0 });
        assert_eq!(Spread::of([4.0, 1.0]), Spread { min: 1.0, median: 2.5, max: 4.0 });
        assert_eq!(Spread::of([]), Spread { min: 0.0, median: 0.0, max: 0.0 });
    }

    #[test]
    fn stages_keep_their_order() {
        let frame = |a, b| FrameTimes { stages: vec![("z", a), ("a", b)], ..FrameTimes::default() };
        let timings = Timings { frames: vec![frame(1.0, 10.0), frame(3.0, 30.0)], ..Timings::default() };
        let medians: Vec<_> = timings.stages().into_iter().map(|(name, s)| (name, s.median)).collect();
        assert_eq!(medians, [("z", 2.0), ("a", 20.0)]);
    }
}
