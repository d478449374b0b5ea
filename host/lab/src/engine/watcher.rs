//! Watchers show the progress of jobs and say when to stop.

use std::time::{Duration, Instant};

use oneiro_base::console::Bars;
use oneiro_base::progress::{self, ProgressBar};

use super::job::Progress;
use super::scheduler::Times;

/// Observer of the engine at work.
pub trait Watch {
    /// Whether to stop.
    fn stops(&self) -> bool;
    /// Called from time to time with the total of robot-steps done.
    fn steps(&mut self, done: u64);
    /// Called when a job has advanced.
    fn advanced(&mut self, progress: Progress);
    /// Called when the work has ended, with the time that its thread has spent.
    fn ended(&mut self, _: &Times) {}
}

/// A watcher for users: a progress bar on standard error, and an optional time limit.
pub struct Watcher {
    until: Option<Instant>,
    bar: ProgressBar,
    /// Whether the bar shows the progress of single jobs instead of a label.
    shows_jobs: bool,
    /// Best fitness of any job.
    best: f32,
    shown: Instant,
}

impl Watcher {
    /// Shows a bar for the given number of robot-steps. Without a label the bar shows the progress of single jobs.
    pub fn new(steps: u64, label: &str, until: Option<Instant>, bars: Bars) -> Self {
        Self {
            until,
            bar: progress::bar(steps, label, bars),
            shows_jobs: label.is_empty(),
            best: f32::NEG_INFINITY,
            shown: Instant::now(),
        }
    }
}

impl Drop for Watcher {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Doesn't watch.
impl Watch for () {
    fn stops(&self) -> bool {
        false
    }

    fn steps(&mut self, _: u64) {}

    fn advanced(&mut self, _: Progress) {}
}

impl Watch for Watcher {
    fn stops(&self) -> bool {
        self.until.is_some_and(|until| Instant::now() >= until)
    }

    fn steps(&mut self, done: u64) {
        if !self.bar.is_hidden() {
            self.bar.set_position(done);
        }
    }

    fn advanced(&mut self, progress: Progress) {
        const BLINK: Duration = Duration::from_millis(50);
        self.best = self.best.max(progress.best);
        if self.shows_jobs && !self.bar.is_hidden() && self.shown.elapsed() >= BLINK {
            self.shown = Instant::now();
            self.bar
                .set_prefix(format!("step {:>4}, best {:>6.1}", progress.done, self.best));
        }
    }
}
