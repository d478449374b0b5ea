//! Watchers show the progress of jobs and say when to stop.

use std::io;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::ProgressBar;
use oneiro_base::console::Bars;
#[cfg(unix)]
use oneiro_base::ending;
use oneiro_base::exit::{Code, Failure, Result};
use oneiro_base::progress;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::{SigId, flag, low_level};

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

/// A flag that the first Ctrl-C or SIGTERM sets. The next Ctrl-C then ends the program at once, exit 130.
pub fn stop_signal() -> Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    let register = || {
        // In this order, so that the first Ctrl-C finds the flag unset.
        flag::register_conditional_shutdown(SIGINT, Code::Aborted as i32, Arc::clone(&stop))?;
        flag::register(SIGINT, Arc::clone(&stop))?;
        flag::register(SIGTERM, Arc::clone(&stop))
    };
    register().map_err(|error| deaf(&error))?;
    for early in std::mem::take(&mut *EARLY.lock().unwrap_or_else(PoisonError::into_inner)) {
        low_level::unregister(early);
    }
    Ok(stop)
}

/// The handlers that end the program at a signal until [`stop_signal`] is called.
static EARLY: Mutex<Vec<SigId>> = Mutex::new(Vec::new());

/// From now until [`stop_signal`] is called, Ctrl-C and SIGTERM end the program at once, exit 75: nothing has begun.
///
/// # Errors
/// Exit 1 if the system registers no signals.
#[cfg(unix)]
pub fn stop_at_once() -> Result {
    for signal in [SIGINT, SIGTERM] {
        // SAFETY: it only does what signal handlers may do.
        let early = unsafe { low_level::register(signal, || ending::stopped_early()) }.map_err(|error| deaf(&error))?;
        EARLY.lock().unwrap_or_else(PoisonError::into_inner).push(early);
    }
    Ok(())
}

fn deaf(error: &io::Error) -> Failure {
    Failure::failed(format_args!("can't listen for Ctrl-C: {error}"))
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
