//! Progress bars on stderr, only where a person looks at them.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::time::Duration;

/// Steps of a bar.
const STEPS: u64 = 1000;

/// Makes the bars of one run.
pub struct Progress {
    quiet: bool,
}

/// One bar; it leaves the terminal when it is dropped.
pub struct Bar(ProgressBar);

impl Progress {
    /// No bar is drawn when `quiet` or when stderr is no terminal.
    pub fn new(quiet: bool) -> Self {
        Self { quiet }
    }

    /// Starts a bar over work whose share done is known.
    pub fn bar(&self, what: &'static str) -> Bar {
        self.start(what, "{msg:24} [{bar:40}] {percent:>3} % {elapsed}")
    }

    /// Does work whose length is not known behind a moving sign.
    pub fn during<T>(&self, what: &'static str, work: impl FnOnce() -> T) -> T {
        let _sign = self.start(what, "{msg:24} {spinner} {elapsed}");
        work()
    }

    fn start(&self, what: &'static str, template: &str) -> Bar {
        // indicatif hides a bar whose target is no terminal
        let target = if self.quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(Some(STEPS), target).with_message(what);
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(200));
        Bar(bar)
    }
}

impl Bar {
    /// Moves the bar to a share of the work, 0 to 1.
    pub fn at(&self, share: f64) {
        self.0.set_position((share.clamp(0.0, 1.0) * STEPS as f64) as u64);
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
