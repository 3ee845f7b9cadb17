//! Steers the work of a frame towards a time: pages drawn per frame first, then a level bias, with hysteresis.

use crate::Config;
use crate::gpu::structs::Counters;

/// Frames over the target before less is drawn.
const OVER: u32 = 3;
/// Frames well under it before more is drawn.
const UNDER: u32 = 10;
/// Well under: this share of the target.
const MARGIN: f64 = 0.85;
/// Steps of the level bias, and its most.
const BIAS_STEP: f32 = 0.25;
const MAX_BIAS: f32 = 4.0;
/// Least pages a frame.
const LEAST_PAGES: u32 = 16;
/// Weight of the past in the cost model, per frame.
const MEMORY: f64 = 0.95;

/// Pages per frame, level bias and cost of a page, from measured times.
#[derive(Debug, Clone)]
pub(crate) struct Steering {
    /// 0: none.
    target_ms: f64,
    most_pages: u32,
    pages: u32,
    sun_pages: u32,
    bias: f32,
    over: u32,
    under: u32,
    page_cost: u32,
    model: Model,
}

impl Steering {
    pub(crate) fn new(config: &Config) -> Self {
        // cold engines draw everything they need in each frame
        let most_pages = if config.cache { config.pages_per_frame } else { 2 * config.page_capacity() };
        Self {
            target_ms: if config.cache { f64::from(config.target_ms) } else { 0.0 },
            most_pages,
            pages: most_pages,
            sun_pages: if config.cache { config.sun_pages_per_frame } else { most_pages },
            bias: 0.0,
            over: 0,
            under: 0,
            page_cost: config.page_cost,
            model: Model::default(),
        }
    }

    /// Layers that may be drawn in the next frame, in which the light may have turned.
    pub(crate) fn pages(&self, light_moved: bool) -> u32 {
        if light_moved { self.pages.min(self.sun_pages) } else { self.pages }
    }

    /// Level bias beyond the configured one.
    pub(crate) fn bias(&self) -> f32 {
        self.bias
    }

    /// What drawing a page costs beside its pairs, in pairs.
    pub(crate) fn page_cost(&self) -> u32 {
        self.page_cost
    }

    /// Takes in the time of a frame and what it drew.
    pub(crate) fn measured(&mut self, gpu_ms: f64, tiles_ms: f64, counters: &Counters) {
        if self.target_ms <= 0.0 || !gpu_ms.is_finite() {
            return;
        }
        let pages = f64::from(counters.drawn + counters.drawn_dynamic);
        let pairs = f64::from(counters.pairs_opaque + counters.pairs_masked);
        if let Some(cost) = self.model.learn(pages, pairs, tiles_ms) {
            self.page_cost = cost.round().clamp(1.0, 1024.0) as u32;
        }
        self.over = if gpu_ms > self.target_ms { self.over + 1 } else { 0 };
        self.under = if gpu_ms < MARGIN * self.target_ms { self.under + 1 } else { 0 };
        if self.over >= OVER {
            self.over = 0;
            // fewer pages help only where that many were drawn
            if self.pages > LEAST_PAGES && pages > 0.5 * f64::from(self.pages) {
                let share = (self.target_ms / gpu_ms).clamp(0.5, 0.9);
                self.pages = ((f64::from(self.pages) * share) as u32).max(LEAST_PAGES);
            } else {
                self.bias = (self.bias + BIAS_STEP).min(MAX_BIAS);
            }
        } else if self.under >= UNDER {
            self.under = 0;
            if self.bias > 0.0 {
                self.bias = (self.bias - BIAS_STEP).max(0.0);
            } else {
                self.pages = (self.pages + self.pages.div_ceil(4)).min(self.most_pages);
            }
        }
    }
}

/// Time = a * pages + b * pairs, by least squares that forget.
#[derive(Debug, Clone, Default)]
struct Model {
    pages2: f64,
    pairs2: f64,
    mixed: f64,
    pages_ms: f64,
    pairs_ms: f64,
}

impl Model {
    /// The cost of a page in pairs, once it is known.
    fn learn(&mut self, pages: f64, pairs: f64, ms: f64) -> Option<f64> {
        if pages <= 0.0 || ms <= 0.0 {
            return None;
        }
        let add = |sum: &mut f64, value: f64| *sum = MEMORY * *sum + value;
        add(&mut self.pages2, pages * pages);
        add(&mut self.pairs2, pairs * pairs);
        add(&mut self.mixed, pages * pairs);
        add(&mut self.pages_ms, pages * ms);
        add(&mut self.pairs_ms, pairs * ms);
        let det = self.pages2 * self.pairs2 - self.mixed * self.mixed;
        // pages and pairs in a fixed ratio say nothing about either
        if det < 1e-3 * self.pages2 * self.pairs2 {
            return None;
        }
        let a = (self.pages_ms * self.pairs2 - self.pairs_ms * self.mixed) / det;
        let b = (self.pairs_ms * self.pages2 - self.pages_ms * self.mixed) / det;
        (a > 0.0 && b > 0.0).then(|| a / b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    fn drew(pages: u32, pairs: u32) -> Counters {
        Counters { drawn: pages, pairs_opaque: pairs, ..Counters::zeroed() }
    }

    fn steering(target_ms: f32) -> Steering {
        Steering::new(&Config { target_ms, ..Config::new([64, 64]) })
    }

    #[test]
    fn nothing_happens_without_a_target() {
        let mut s = steering(0.0);
        (0..100).for_each(|_| s.measured(1e3, 1e3, &drew(256, 1000)));
        assert_eq!((s.pages(false), s.pages(true), s.bias(), s.page_cost()), (192, 96, 0.0, 16));
    }

    /// A GPU that needs 4 ms and 0.1 ms a page.
    #[test]
    fn pages_settle_at_the_target() {
        let mut s = steering(10.0);
        let mut last = 0.0;
        for _ in 0..200 {
            last = 4.0 + 0.1 * f64::from(s.pages(false));
            s.measured(last, last - 4.0, &drew(s.pages(false), 1000));
        }
        assert!((6.0..=12.5).contains(&last) && s.bias() == 0.0, "{last} ms, {} pages", s.pages(false));
    }

    #[test]
    fn the_bias_gives_way_when_few_pages_are_drawn_and_comes_back() {
        let mut s = steering(10.0);
        (0..12).for_each(|_| s.measured(15.0, 0.0, &drew(0, 0)));
        assert_eq!(s.bias(), 4.0 * BIAS_STEP);
        (0..4).for_each(|_| s.measured(9.0, 0.0, &drew(0, 0)));
        assert_eq!(s.bias(), 4.0 * BIAS_STEP, "within the margin nothing changes");
        (0..40).for_each(|_| s.measured(5.0, 0.0, &drew(0, 0)));
        assert_eq!((s.bias(), s.pages(false)), (0.0, 192));
    }

    #[test]
    fn the_cost_of_a_page_is_learnt() {
        let mut s = steering(1e6);
        for i in 0..60 {
            let (pages, pairs) = (20 + 13 * (i % 7), 400 + 170 * (i % 5));
            s.measured(1.0, 0.4 * f64::from(pages) + 0.01 * f64::from(pairs), &drew(pages, pairs));
        }
        assert_eq!(s.page_cost(), 40);
    }
}
