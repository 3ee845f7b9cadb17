//! What the overlay says about method and frame.

use super::overlay::Line;
use crate::methods::{FrameTimes, Statistics};

/// What a frame was like.
pub(super) struct Status<'a> {
    pub(super) method: &'a str,
    /// Its place among the methods, from 1, and their number.
    pub(super) place: [usize; 2],
    pub(super) device: &'a str,
    pub(super) cpu: bool,
    /// From picture to picture.
    pub(super) frame_ms: f64,
    pub(super) times: &'a FrameTimes,
    pub(super) statistics: &'a Statistics,
    /// Whether visibility is computed on the CPU.
    pub(super) slow: bool,
    pub(super) frozen: bool,
    pub(super) paged: bool,
    pub(super) shows: &'a str,
}

impl Status<'_> {
    pub(super) fn lines(&self) -> Vec<Line> {
        let [place, of] = self.place;
        let mut lines = vec![format!("{} ({place} of {of})", self.method)];
        lines.push(self.device.to_owned() + if self.cpu { " - a CPU: its times say little about GPUs" } else { "" });
        if self.slow {
            lines.push("SLOW: rays on the CPU, anew whenever something moves".to_owned());
        }
        let times = self.times;
        let mut stages = vec![("depth_prepass", times.prepass_ms)];
        stages.extend(&times.stages);
        let stages: Vec<_> = stages.iter().map(|(name, ms)| format!("{name} {ms:.1}")).collect();
        lines.push(format!("frame {:.0} ms, method {:.1} ms: {}", self.frame_ms, times.ms, stages.join(", ")));
        if self.paged {
            lines.push(self.pages());
        }
        lines.push(format!("shows: {}", self.shows));
        if self.frozen {
            lines.push("FROZEN: the pages of an earlier camera; sun and time stand still".to_owned());
        }
        lines.into_iter().map(|line| (line, None)).collect()
    }

    fn pages(&self) -> String {
        let count = |key: &str| self.statistics.counters.iter().find(|(name, _)| *name == key).map_or(0, |c| c.1);
        let coarser: u32 = self.statistics.levels.iter().map(|level| level.refused).sum();
        format!(
            "pages: {} serve, {} cached, {} drawn, {} put off, {coarser} coarser than asked for",
            count("pages_serving"),
            count("pages_hit"),
            count("pages_drawn"),
            count("pages_deferred"),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::LevelStatistics;

    #[test]
    fn a_cpu_and_slow_methods_are_named() {
        let times = FrameTimes { prepass_ms: 1.0, ms: 2.5, wall_ms: 3.0, stages: vec![("lookup", 2.5)] };
        let levels = vec![LevelStatistics { refused: 3, ..Default::default() }; 2];
        let counters = vec![("pages_drawn", 7)];
        let statistics = Statistics { effective_resolution: 0.0, levels, counters };
        let mut status = Status {
            method: "rmsm",
            place: [1, 4],
            device: "llvmpipe",
            cpu: true,
            frame_ms: 9.6,
            times: &times,
            statistics: &statistics,
            slow: false,
            frozen: false,
            paged: true,
            shows: "shaded",
        };
        let text = |status: &Status<'_>| status.lines().iter().map(|l| l.0.clone()).collect::<Vec<_>>().join("\n");
        let plain = text(&status);
        for part in ["rmsm (1 of 4)", "a CPU", "frame 10 ms", "depth_prepass 1.0, lookup 2.5", "7 drawn", "6 coarser"] {
            assert!(plain.contains(part), "{part} is not in {plain}");
        }
        assert!(!plain.contains("SLOW") && !plain.contains("FROZEN"));
        (status.cpu, status.slow, status.frozen, status.paged) = (false, true, true, false);
        let other = text(&status);
        assert!(other.contains("SLOW") && other.contains("FROZEN"), "{other}");
        assert!(!other.contains("CPU:") && !other.contains("pages:"), "{other}");
    }
}
