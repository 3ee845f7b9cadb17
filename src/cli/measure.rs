//! Times of methods that run by turns.

use serde::Serialize;
use umbrage::lab::{Lab, LabError};
use umbrage::methods::{FrameTimes, Method, Sampling};

/// Frames of each method before the timed ones; the first of them is the cold one.
pub const WARM_UP: u32 = 3;
/// Most frames before the timed ones, for methods that spread their work over several.
const MOST_WARM_UP: u32 = 64;
/// The counter of pages that a method has put off to later frames.
const DEFERRED: &str = "pages_deferred";

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

/// What many frames come to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Tail {
    pub median: f64,
    /// The nearest rank: the least value that 95 % of the values do not exceed.
    pub p95: f64,
    /// The greatest value.
    pub worst: f64,
}

impl Tail {
    /// All zero where there are no values.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> = values.into_iter().collect();
        sorted.sort_by(f64::total_cmp);
        let rank = (sorted.len() * 95).div_ceil(100);
        let p95 = sorted.get(rank.saturating_sub(1)).copied().unwrap_or(0.0);
        let Spread { median, max, .. } = Spread::of(sorted);
        Self { median, p95, worst: max }
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

/// Runs every method once a round; `share` is told how much is done. Rounds are timed once no method defers a page.
pub fn by_turns(
    lab: &Lab,
    methods: &mut [Box<dyn Method>],
    rounds: u32,
    share: impl Fn(f64),
) -> Result<Vec<Timings>, LabError> {
    let mut timings = vec![Timings::default(); methods.len()];
    let all = f64::from(WARM_UP + rounds);
    for round in 0..MOST_WARM_UP {
        if round >= WARM_UP && !any_defers(lab, methods)? {
            break;
        }
        for (method, timings) in methods.iter_mut().zip(&mut timings) {
            let frame = method.frame(lab)?;
            if round == 0 {
                timings.cold = frame;
            }
        }
        share(f64::from((round + 1).min(WARM_UP)) / all);
    }
    for round in 0..rounds {
        for (method, timings) in methods.iter_mut().zip(&mut timings) {
            timings.frames.push(method.frame(lab)?);
        }
        share(f64::from(WARM_UP + round + 1) / all);
    }
    Ok(timings)
}

/// Visibility of a method's last frame, one image for each light of the view.
pub fn visibility(lab: &Lab, method: &mut dyn Method) -> Result<Vec<Vec<f32>>, LabError> {
    (0..lab.view().lights.len()).map(|light| method.visibility(lab, light)).collect()
}

/// Sampling errors of a method's last frame, for each light of the view; none where it cannot tell.
pub fn sampling(lab: &Lab, method: &mut dyn Method) -> Result<Vec<Sampling>, LabError> {
    let each = (0..lab.view().lights.len()).map(|light| method.sampling(lab, light).transpose());
    each.flatten().collect()
}

fn any_defers(lab: &Lab, methods: &mut [Box<dyn Method>]) -> Result<bool, LabError> {
    for method in methods {
        if method.statistics(lab)?.counters.iter().any(|&(name, pages)| name == DEFERRED && pages > 0) {
            return Ok(true);
        }
    }
    Ok(false)
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
    fn tails() {
        let tail = Tail::of((1..=100).rev().map(f64::from));
        assert_eq!(tail, Tail { median: 50.5, p95: 95.0, worst: 100.0 });
        // the nearest rank of 20 values is the 19th, of 19 the last
        assert_eq!(Tail::of((1..=20).map(f64::from)).p95, 19.0);
        assert_eq!(Tail::of((1..=19).map(f64::from)).p95, 19.0);
        assert_eq!(Tail::of([7.0]), Tail { median: 7.0, p95: 7.0, worst: 7.0 });
        assert_eq!(Tail::of([]), Tail { median: 0.0, p95: 0.0, worst: 0.0 });
    }

    #[test]
    fn stages_keep_their_order() {
        let frame = |a, b| FrameTimes { stages: vec![("z", a), ("a", b)], ..FrameTimes::default() };
        let timings = Timings { frames: vec![frame(1.0, 10.0), frame(3.0, 30.0)], ..Timings::default() };
        let medians: Vec<_> = timings.stages().into_iter().map(|(name, s)| (name, s.median)).collect();
        assert_eq!(medians, [("z", 2.0), ("a", 20.0)]);
    }
}
